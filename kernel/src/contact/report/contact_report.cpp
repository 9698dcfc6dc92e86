// The public functions of contact reports.
#include "dvdx/contact_report.hpp"

#include <algorithm>
#include <utility>

#include "contact/report/contact_recorder.hpp"

namespace dvdx {

ContactReport::ContactReport(std::size_t contacts, std::span<ContactEvent> room) : parts_(new Parts(contacts, room)) {}
ContactReport::ContactReport(ContactReport&& other) noexcept : parts_(std::exchange(other.parts_, nullptr)) {}
ContactReport& ContactReport::operator=(ContactReport&& other) noexcept {
  std::swap(parts_, other.parts_);
  return *this;
}
ContactReport::~ContactReport() { delete parts_; }

std::size_t ContactReport::contacts() const noexcept { return parts_ != nullptr ? parts_->centers.size() : 0; }

ContactSum ContactReport::of(std::size_t contact) const noexcept {
  if (contact >= contacts()) return {};
  const std::int64_t* const words = parts_->words.data() + contact * contact_words;
  ContactSum sum{.hits = static_cast<std::uint64_t>(*words)};
  const auto number = [&](std::size_t n) {
    return rounded(std::span<const std::int64_t, exact_words>(words + 1 + n * exact_words, exact_words));
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sum.impulse[axis] = number(axis);
    sum.torque_impulse[axis] = number(3 + axis);
  }
  return sum;
}

std::span<const ContactEvent> ContactReport::events() const noexcept {
  return parts_ != nullptr ? parts_->room.first(parts_->kept) : std::span<ContactEvent>();
}
std::uint64_t ContactReport::lost() const noexcept { return parts_ != nullptr ? parts_->lost : 0; }
std::uint64_t ContactReport::steps() const noexcept { return parts_ != nullptr ? parts_->steps : 0; }
void ContactReport::set_steps(std::uint64_t steps) noexcept {
  if (parts_ != nullptr) parts_->steps = steps;
}

void ContactReport::clear_events() noexcept {
  if (parts_ == nullptr) return;
  parts_->claimed = 0;
  parts_->kept = 0;
  parts_->lost = 0;
}

void ContactReport::clear() noexcept {
  if (parts_ == nullptr) return;
  clear_events();
  std::fill(parts_->words.begin(), parts_->words.end(), 0);
}

std::span<const std::int64_t> ContactReport::words() const noexcept {
  return parts_ != nullptr ? std::span<const std::int64_t>(parts_->words) : std::span<const std::int64_t>();
}

void ContactReport::add(std::span<const std::int64_t> words) noexcept {
  if (parts_ == nullptr) return;
  for (std::size_t k = 0; k < std::min(words.size(), parts_->words.size()); ++k) parts_->words[k] += words[k];
  ++parts_->joined;
}

}  // namespace dvdx
