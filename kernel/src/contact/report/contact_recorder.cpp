#include "contact/report/contact_recorder.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <tuple>
#include <utility>

#include "math/vec3.hpp"

namespace dvdx {
namespace {

Vec3 center_of(const Contact& contact) noexcept {
  return std::visit(
      [](const auto& c) {
        if constexpr (requires { c.center; }) {
          return c.center;
        } else {
          return Vec3{};
        }
      },
      contact);
}

// Returns an integer in the order of the numbers. A NaN has a place too, before or behind all others: a sort needs an order.
std::int64_t ordinal(double number) noexcept {
  const auto bits = std::bit_cast<std::int64_t>(number);
  return bits >= 0 ? bits : std::numeric_limits<std::int64_t>::min() - bits;
}

bool is_before(const ContactEvent& a, const ContactEvent& b) noexcept {
  const auto of = [](const Vec3& v) { return std::array{ordinal(v[0]), ordinal(v[1]), ordinal(v[2])}; };
  const auto key = [&](const ContactEvent& e) {
    return std::tuple(e.step, e.particle, ordinal(e.time), e.contact, of(e.x), of(e.n), of(e.impulse));
  };
  return key(a) < key(b);
}

}  // namespace

void begin_report(ContactReport::Parts& report, const Scene& scene) noexcept {
  for (std::size_t j = 0; j < scene.contacts.size(); ++j) report.centers[j] = {center_of(scene.contacts[j]), {}};
  constexpr std::uint64_t most = std::uint64_t{1} << 30U;
  if (report.joined.load(std::memory_order_relaxed) < most) return;
  report.joined = 0;
  for (std::size_t first = 0; first < report.words.size(); first += contact_words) {
    for (std::size_t sum = 0; sum < contact_sums; ++sum) {
      carry(std::span(report.words).subspan(first + 1 + sum * exact_words, exact_limbs));
    }
  }
}

void end_report(ContactReport::Parts& report, std::size_t steps) noexcept {
  const std::size_t claimed = report.claimed;
  const std::size_t kept = std::min(claimed, report.room.size());
  std::sort(report.room.begin() + static_cast<std::ptrdiff_t>(report.kept),
            report.room.begin() + static_cast<std::ptrdiff_t>(kept), is_before);
  report.lost += claimed - kept;
  report.claimed = kept;
  report.kept = kept;
  report.steps += steps;
}

// ---- sums ----------------------------------------------------------------------------------------------------------------

void ContactSums::add(std::size_t sum, double term) noexcept {
  for_each_word(term, [&](std::size_t word, std::int64_t number) {
    words_[sum][word] += number;
    first_[sum] = std::min(first_[sum], word);
    end_[sum] = std::max(end_[sum], word + 1);
  });
}

void ContactSums::add(const Vec3& impulse, const Vec3& torque) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    waiting_[axis][waiting_count_] = impulse[axis];
    waiting_[3 + axis][waiting_count_] = torque[axis];
  }
  if (++waiting_count_ == ExactLanes::lanes) add_waiting();
}

void ContactSums::add_waiting() noexcept {
  if (waiting_count_ < few_waiting) {  // too few to set up lanes for them
    for (std::size_t sum = 0; sum < contact_sums; ++sum) {
      for (std::size_t k = 0; k < waiting_count_; ++k) add(sum, waiting_[sum][k]);
    }
    waiting_count_ = 0;
    return;
  }
  for (auto& terms : waiting_) std::fill(terms.begin() + static_cast<std::ptrdiff_t>(waiting_count_), terms.end(), 0.0);
  waiting_count_ = 0;
  add(waiting_);
}

void ContactSums::add(const ContactTerms& terms) noexcept {
  for (std::size_t sum = 0; sum < contact_sums; ++sum) {
    lanes_[sum].add(terms[sum], [&](double term) { add(sum, term); });
  }
  // Carries before words overflow, if one thread takes very many steps.
  terms_ += ExactLanes::lanes + 2;  // the terms, and the two sums of a flush
  if (terms_ < most_terms) return;
  terms_ = 0;
  for (std::size_t sum = 0; sum < contact_sums; ++sum) {
    carry(std::span(words_[sum]).first(exact_limbs));
    end_[sum] = std::max(end_[sum], exact_limbs);
  }
}

// Threads may call it concurrently: integer sums do not depend on their order.
void ContactSums::join(ContactReport::Parts& report) noexcept {
  std::int64_t* const to = report.words.data() + contact_ * contact_words;
  const auto add = [](std::int64_t& word, std::int64_t number) {
    if (number != 0) std::atomic_ref(word).fetch_add(number, std::memory_order_relaxed);
  };
  add(*to, hits_);
  add_waiting();
  for (std::size_t sum = 0; sum < contact_sums; ++sum) {
    lanes_[sum].flush([&](double term) { this->add(sum, term); });
    if (first_[sum] == exact_words) continue;
    std::int64_t* const of_sum = to + 1 + sum * exact_words;
    const std::size_t end = std::min(end_[sum] + 2, exact_limbs);  // carries go up two limbs
    if (first_[sum] < end) carry(std::span(words_[sum]).subspan(first_[sum], end - first_[sum]));
    for (std::size_t word = first_[sum]; word < end; ++word) add(of_sum[word], words_[sum][word]);
    add(of_sum[exact_limbs], words_[sum][exact_limbs]);
  }
  report.joined.fetch_add(1, std::memory_order_relaxed);
}

// ---- particles -----------------------------------------------------------------------------------------------------------

std::optional<std::size_t> LoggedParticles::number(std::size_t element) const noexcept {
  if (order_ == nullptr) {
    const bool is_fixed = std::binary_search(scene_.fixed.begin(), scene_.fixed.end(), first_ + element);
    if (element >= count_ || is_fixed) return std::nullopt;
    return first_ + element;
  }
  std::optional<std::size_t> particle = order_->particle_at(element);
  if (particle && (*particle >= count_ || inverse_masses_[*particle] == 0)) particle.reset();
  if (particle && is_own_ != nullptr && is_own_[*particle] == 0) particle.reset();
  return particle;
}

// ---- a task ---------------------------------------------------------------------------------------------------------------

template <class T>
ContactRecorder<T>::~ContactRecorder() {
  for (auto& sums : sums_) {
    if (sums) sums->join(report_);
  }
}

template <class T>
ContactSums& ContactRecorder<T>::sums_of(std::size_t contact) noexcept {
  std::optional<ContactSums>& sums = sums_[contact % sums_.size()];
  if (sums && sums->contact() != contact) {
    sums->join(report_);
    sums.reset();
  }
  if (!sums) sums.emplace(contact);
  return *sums;
}

template <class T>
auto ContactRecorder<T>::add(const ContactPush<T>& push, bool is_hit) noexcept -> std::optional<Impulse> {
  const std::optional<std::size_t> particle = particles_.number(push.particle);
  if (!particle) return std::nullopt;
  const double mass = particles_.mass(*particle);
  const Vec3 origin = particles_.origin();
  const TorqueCenter& center = report_.centers[push.contact];
  const auto t = static_cast<double>(push.t);
  Impulse impulse{.particle = *particle};
  Vec3 arm{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    impulse.x[axis] = static_cast<double>(push.x[axis]) + origin[axis];
    impulse.on_surface[axis] = -(mass * static_cast<double>(push.dv[axis]));
    arm[axis] = impulse.x[axis] - (center.at[axis] - t * center.velocity[axis]);
  }
  ContactSums& sums = sums_of(push.contact);
  sums.add(impulse.on_surface, cross(arm, impulse.on_surface));
  if (is_hit) sums.count_hits(1);
  return impulse;
}

template <class T>
void ContactRecorder<T>::take_hold(const ContactPush<T>& push) noexcept {
  add(push, false);
}

template <class T>
void ContactRecorder<T>::take_impact(const ContactPush<T>& push, const std::array<T, 3>& normal) noexcept {
  const std::optional<Impulse> impulse = add(push, true);
  if (impulse) keep_event(*impulse, push.contact, normal, push.t);
}

template <class T>
void ContactRecorder<T>::keep_event(const Impulse& impulse, std::size_t contact, const std::array<T, 3>& normal, T t) noexcept {
  if (report_.room.empty()) return;
  const std::size_t place = report_.claimed.fetch_add(1, std::memory_order_relaxed);
  if (place >= report_.room.size()) return;
  const double passed = 1 - static_cast<double>(t) / static_cast<double>(static_cast<T>(h_));
  report_.room[place] = {.step = step_,
                         .time = start_.seconds + (start_.carry + h_ * passed),
                         .particle = impulse.particle,
                         .contact = contact,
                         .x = impulse.x,
                         .n = {static_cast<double>(normal[0]), static_cast<double>(normal[1]), static_cast<double>(normal[2])},
                         .impulse = impulse.on_surface};
}

// ---- particles side by side ----------------------------------------------------------------------------------------------

template <class T>
void ContactRecorder<T>::take_holds(const ContactPushes<T>& pushes) noexcept {
  add(pushes, false);
}

template <class T>
void ContactRecorder<T>::take_impacts(const ContactPushes<T>& pushes) noexcept {
  add(pushes, true);
}

template <class T>
auto ContactRecorder<T>::side_of(const ContactPushes<T>& pushes) const noexcept -> Side {
  Side side;
  side.lanes = pushes.lanes;
  const bool are_in_order = particles_.are_in_order();
  for (std::size_t k = 0; k < ExactLanes::lanes; ++k) {
    std::optional<std::size_t> number;
    if (are_in_order) {
      if (pushes.first + k < particles_.count()) number = particles_.first() + pushes.first + k;
    } else if ((pushes.lanes >> k & 1U) != 0) {
      number = particles_.number(pushes.first + k);
    }
    side.particle[k] = number.value_or(0);
    side.mass[k] = number ? particles_.mass(*number) : 0;
    if (!number) side.lanes &= ~(std::uint64_t{1} << k);
  }
  return side;
}

template <class T>
void ContactRecorder<T>::add(const ContactPushes<T>& pushes, bool are_hits) noexcept {
  const Side side = side_of(pushes);
  for (std::uint64_t left = side.lanes; left != 0;) {
    const std::uint32_t contact = pushes.contact[static_cast<std::size_t>(std::countr_zero(left))];
    std::uint64_t own = 0;
    for (std::size_t k = 0; k < ExactLanes::lanes; ++k) own |= std::uint64_t{pushes.contact[k] == contact} << k;
    own &= left;
    left &= ~own;
    if (own == pushes.lanes) return add(pushes, side, are_hits);
    if (std::popcount(own) < few) {
      add_each(pushes, own, are_hits);
      continue;
    }
    ContactPushes<T> some = pushes;  // the other lanes get 0, so that not even a NaN counts
    for (std::size_t k = 0; k < ExactLanes::lanes; ++k) {
      if ((own >> k & 1U) != 0) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) some.x[axis][k] = some.dv[axis][k] = 0;
    }
    some.lanes = own;
    add(some, side, are_hits);
  }
}

template <class T>
void ContactRecorder<T>::add_each(const ContactPushes<T>& pushes, std::uint64_t lanes, bool are_hits) noexcept {
  for (; lanes != 0; lanes &= lanes - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(lanes));
    const auto of = [k](const auto& axes) { return std::array{axes[0][k], axes[1][k], axes[2][k]}; };
    const ContactPush<T> push{pushes.first + k, pushes.contact[k], of(pushes.x), of(pushes.dv), pushes.t[k]};
    if (are_hits) {
      take_impact(push, of(pushes.n));
    } else {
      take_hold(push);
    }
  }
}

// Takes pushes of one contact. The sums are the same as if each particle were added by itself.
template <class T>
void ContactRecorder<T>::add(const ContactPushes<T>& pushes, const Side& side, bool are_hits) noexcept {
  const auto first = static_cast<std::size_t>(std::countr_zero(pushes.lanes));
  const std::size_t contact = pushes.contact[first];
  const Vec3 origin = particles_.origin();
  const TorqueCenter center = report_.centers[contact];
  ContactTerms x, arm, terms;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < ExactLanes::lanes; ++k) {
      x[axis][k] = static_cast<double>(pushes.x[axis][k]) + origin[axis];
      terms[axis][k] = -(side.mass[k] * static_cast<double>(pushes.dv[axis][k]));
      arm[axis][k] = x[axis][k] - (center.at[axis] - static_cast<double>(pushes.t[k]) * center.velocity[axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t b = (axis + 1) % 3;
    const std::size_t c = (axis + 2) % 3;
    for (std::size_t k = 0; k < ExactLanes::lanes; ++k) {
      terms[3 + axis][k] = arm[b][k] * terms[c][k] - arm[c][k] * terms[b][k];
    }
  }
  ContactSums& sums = sums_of(contact);
  sums.add(terms);
  if (!are_hits) return;
  sums.count_hits(std::popcount(pushes.lanes));
  if (report_.room.empty()) return;
  for (std::uint64_t lanes = pushes.lanes; lanes != 0; lanes &= lanes - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(lanes));
    const Impulse impulse{
        .particle = side.particle[k], .x = {x[0][k], x[1][k], x[2][k]}, .on_surface = {terms[0][k], terms[1][k], terms[2][k]}};
    keep_event(impulse, contact, {pushes.n[0][k], pushes.n[1][k], pushes.n[2][k]}, pushes.t[k]);
  }
}

template class ContactRecorder<float>;
template class ContactRecorder<double>;

}  // namespace dvdx
