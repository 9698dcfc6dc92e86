#include "springs/list_rates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace dvdx {
namespace {

constexpr std::size_t block = 32;  // particles

void take_most(ListRates::Most& most, const ListRates::Most& other) noexcept {
  most = {std::max(most.k, other.k), std::max(most.c, other.c), std::max(most.own_k, other.own_k),
          std::max(most.own_c, other.own_c)};
}

}  // namespace

ListRates::ListRates(std::span<const JoinedPair> springs, std::span<const double> w)
    : pull_k_(springs.size()),
      pull_c_(springs.size()),
      met_(springs.size()),
      first_of_(w.size() + 1, 0),
      first_at_(w.size() + 1, 0),
      at_(2 * springs.size()),
      whole_at_(w.size(), 0),
      of_block_((w.size() + block - 1) / block) {
  for (const JoinedPair& s : springs) {
    ends_.push_back({s.a, s.b});
    k_.push_back(s.k);
    l_.push_back(s.l);
    c_.push_back(s.c);
    q_.push_back(s.q);
    source_.push_back(s.source);
    is_damped_ = is_damped_ || s.c != 0;
    has_zero_length_ = has_zero_length_ || s.q != 0;
    ++first_of_[s.a + 1];
    ++first_at_[s.a + 1];
    ++first_at_[s.b + 1];
  }
  std::partial_sum(first_of_.begin(), first_of_.end(), first_of_.begin());
  std::partial_sum(first_at_.begin(), first_at_.end(), first_at_.begin());
  std::vector<std::uint32_t> next(first_at_.begin(), first_at_.end() - 1);
  for (std::size_t s = 0; s < size(); ++s) {
    at_[next[ends_[s].a]++] = static_cast<std::uint32_t>(s);
    at_[next[ends_[s].b]++] = static_cast<std::uint32_t>(s);
    met_[s] = springs[s].is_broken ? nobody() : ends_[s].b;
    pull_as_is(s);
    for (const std::size_t i : {ends_[s].a, ends_[s].b}) whole_at_[i] += springs[s].is_broken ? 0U : 1U;
  }
  for (Products* const of : {&of_k_, &of_c_}) {
    of->magnitudes.assign(w.size() + 1, -std::numeric_limits<double>::infinity());
    of->own.assign(w.size(), 0);
  }
  std::uint32_t most_at = 0;
  for (std::size_t i = 0; i < w.size(); ++i) most_at = std::max(most_at, first_at_[i + 1] - first_at_[i]);
  sum_of_.resize(most_at + 1, 0);
  look_at_all(w);
}

// A uniform set_stiffness() stores the stiffness of whole springs in pull_k_ alone. Their k_ is then out of date.
JoinedPair ListRates::spring(std::size_t s) const noexcept {
  return {.a = ends_[s].a,
          .b = ends_[s].b,
          .k = met_[s] == nobody() || has_zero_length_ ? k_[s] : pull_k_[s],
          .l = l_[s],
          .c = c_[s],
          .is_broken = met_[s] == nobody(),
          .source = source_[s],
          .q = q_[s]};
}

void ListRates::mark(std::size_t s, SpringIs state) noexcept {
  k_[s] = spring(s).k;
  met_[s] = state == SpringIs::torn ? nobody() : ends_[s].b;
  pull_as_is(s);
}

void ListRates::pull_as_is(std::size_t s) noexcept {
  const bool is_whole = met_[s] != nobody();
  pull_k_[s] = is_whole ? k_[s] + q_[s] : 0;
  pull_c_[s] = is_whole ? c_[s] : 0;
}

// Sums in the order of the list, as sum_bound() of springs/frequencies.cpp does, so that both have the same bits.
void ListRates::sum_up(std::span<const double> pull, std::span<const std::uint32_t> springs, double w, std::size_t particle,
                       Products& products) noexcept {
  double magnitudes = 0;
  double own = 0;
  for (const std::uint32_t s : springs) {
    magnitudes += std::abs(pull[s]);
    own += pull[s];
  }
  products.magnitudes[particle] = w * magnitudes;
  products.own[particle] = w * own;
}

void ListRates::sum_up(std::span<const double> w, std::size_t particle) noexcept {
  sum_up(pull_k_, springs_at(particle), w[particle], particle, of_k_);
  if (is_damped_) sum_up(pull_c_, springs_at(particle), w[particle], particle, of_c_);
}

// Rounding is monotone, so max(a + b) = a + max(b).
void ListRates::look_at_block(std::size_t number) noexcept {
  const auto most_met = [&](const Products& of, std::size_t i) {
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t s = first_of_[i]; s < first_of_[i + 1]; ++s) most = std::max(most, of.magnitudes[met_[s]]);
    return of.magnitudes[i] + most;
  };
  Most most;
  const std::size_t to = std::min(of_k_.own.size(), (number + 1) * block);
  for (std::size_t i = number * block; i < to; ++i) {
    most.k = std::max(most.k, most_met(of_k_, i));
    most.own_k = std::max(most.own_k, of_k_.own[i]);
    if (!is_damped_) continue;
    most.c = std::max(most.c, most_met(of_c_, i));
    most.own_c = std::max(most.own_c, of_c_.own[i]);
  }
  of_block_[number] = most;
}

// A particle's springs begin in its own block, or in the blocks of their lower ends, whose numbers ascend.
void ListRates::look_around(std::size_t particle) noexcept {
  std::size_t seen = of_block_.size();
  for (const std::uint32_t s : springs_at(particle)) {
    const std::size_t of = ends_[s].a / block;
    if (of != std::exchange(seen, of)) look_at_block(of);
  }
  if (seen != particle / block) look_at_block(particle / block);
}

void ListRates::look_at_all(std::span<const double> w) noexcept {
  for (std::size_t i = 0; i < w.size(); ++i) sum_up(w, i);
  look_at_blocks();
}

void ListRates::look_at_blocks() noexcept {
  for (std::size_t n = 0; n < of_block_.size(); ++n) look_at_block(n);
}

// All particles with the same number of whole springs have the same sum.
void ListRates::look_at_all_alike(std::span<const double> w, double k) noexcept {
  for (std::size_t n = 1; n < sum_of_.size(); ++n) sum_of_[n] = sum_of_[n - 1] + k;
  for (std::size_t i = 0; i < w.size(); ++i) of_k_.magnitudes[i] = of_k_.own[i] = w[i] * sum_of_[whole_at_[i]];
  look_at_blocks();
}

void ListRates::set_mass(std::span<const double> w, std::size_t particle) noexcept {
  sum_up(w, particle);
  look_around(particle);
}

void ListRates::set(std::span<const double> w, std::uint32_t spring, SpringIs state) noexcept {
  mark(spring, state);
  for (const std::size_t i : {ends_[spring].a, ends_[spring].b}) whole_at_[i] += state == SpringIs::torn ? -1U : 1U;
  for (const std::size_t i : {ends_[spring].a, ends_[spring].b}) sum_up(w, i);
  for (const std::size_t i : {ends_[spring].a, ends_[spring].b}) look_around(i);
}

void ListRates::set_stiffness(std::span<const double> w, const SourceRange& of, const Scalars& k, double c) noexcept {
  const auto set_k = [&](const auto& k_of) {
    for (std::size_t s = 0; s < size(); ++s) {
      if (!of.holds(source_[s])) continue;
      k_[s] = k_of(source_[s] - of.first);
      pull_k_[s] = met_[s] == nobody() ? 0 : k_[s] + q_[s];
    }
  };
  const auto set_c = [&] {
    is_damped_ = false;
    for (std::size_t s = 0; s < size(); ++s) {
      if (of.holds(source_[s])) {
        c_[s] = c;
        pull_c_[s] = met_[s] == nobody() ? 0 : c;
      }
      is_damped_ = is_damped_ || c_[s] != 0;
    }
  };
  const bool are_all = of.first == 0 && of.end == size();
  const bool is_damping_kept = c == 0 && !is_damped_;
  if (k.is_uniform() && are_all && is_damping_kept && !has_zero_length_) {
    const double all = k[0];
    std::fill(pull_k_.begin(), pull_k_.end(), all);
    const std::size_t whole = std::accumulate(whole_at_.begin(), whole_at_.end(), std::size_t{0}) / 2;
    for (std::size_t s = 0; s < size() && whole != size(); ++s) {
      if (met_[s] != nobody()) continue;
      k_[s] = all;
      pull_k_[s] = 0;
    }
    return look_at_all_alike(w, all);
  }
  if (k.is_uniform()) {
    set_k([all = k[0]](std::size_t) { return all; });
  } else {
    set_k([each = k.each().data()](std::size_t source) { return each[source]; });
  }
  if (!is_damping_kept) set_c();
  look_at_all(w);
}

// From now on k_ holds each spring's own stiffness.
void ListRates::set_zero_length(std::span<const double> w, const SourceRange& of, const Scalars& q) noexcept {
  for (std::size_t s = 0; s < size() && !has_zero_length_; ++s) k_[s] = spring(s).k;
  has_zero_length_ = true;
  for (std::size_t s = 0; s < size(); ++s) {
    if (!of.holds(source_[s])) continue;
    q_[s] = q[source_[s] - of.first];
    pull_k_[s] = met_[s] == nobody() ? 0 : k_[s] + q_[s];
  }
  look_at_all(w);
}

ListRates::Most ListRates::most() const noexcept {
  Most most;
  for (const Most& of : of_block_) take_most(most, of);
  return most;
}

}  // namespace dvdx
