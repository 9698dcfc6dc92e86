#include "compile/list_rates.hpp"

#include <algorithm>
#include <cmath>
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

ListRates::ListRates(std::vector<JoinedPair> springs, std::span<const double> w)
    : springs_(std::move(springs)),
      first_at_(w.size() + 1, 0),
      at_(2 * springs_.size()),
      sums_(w.size()),
      of_particle_(w.size()),
      of_block_((w.size() + block - 1) / block) {
  for (const JoinedPair& s : springs_) {
    ++first_at_[s.a + 1];
    ++first_at_[s.b + 1];
  }
  std::partial_sum(first_at_.begin(), first_at_.end(), first_at_.begin());
  std::vector<std::uint32_t> next(first_at_.begin(), first_at_.end() - 1);
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    at_[next[springs_[s].a]++] = static_cast<std::uint32_t>(s);
    at_[next[springs_[s].b]++] = static_cast<std::uint32_t>(s);
  }
  look_at_all(w);
}

// In the order of the list, as sum_bound() of compile/limit.cpp does: the same bits.
void ListRates::add(Sums& sums, const JoinedPair& s) noexcept {
  const double k = stiffness_of(s);
  const double c = damping_of(s);
  sums = {sums.k + std::abs(k), sums.c + std::abs(c), sums.own_k + k, sums.own_c + c};
}

ListRates::Most ListRates::most_of(const JoinedPair& s, std::span<const double> w) const noexcept {
  const Sums& a = sums_[s.a];
  const Sums& b = sums_[s.b];
  return {w[s.a] * a.k + w[s.b] * b.k, w[s.a] * a.c + w[s.b] * b.c, std::max(w[s.a] * a.own_k, w[s.b] * b.own_k),
          std::max(w[s.a] * a.own_c, w[s.b] * b.own_c)};
}

void ListRates::sum_up(std::size_t particle) noexcept {
  Sums sums;
  for (const std::uint32_t s : springs_at(particle)) add(sums, springs_[s]);
  sums_[particle] = sums;
}

void ListRates::look_at(std::span<const double> w, std::size_t particle) noexcept {
  Most most;
  for (const std::uint32_t s : springs_at(particle)) {
    if (!springs_[s].is_broken) take_most(most, most_of(springs_[s], w));
  }
  of_particle_[particle] = most;
}

void ListRates::look_at_block(std::size_t number) noexcept {
  Most most;
  const std::size_t to = std::min(of_particle_.size(), (number + 1) * block);
  for (std::size_t i = number * block; i < to; ++i) take_most(most, of_particle_[i]);
  of_block_[number] = most;
}

void ListRates::look_around(std::span<const double> w, std::size_t particle) noexcept {
  const auto other = [&](std::uint32_t s) -> std::size_t { return springs_[s].a == particle ? springs_[s].b : springs_[s].a; };
  look_at(w, particle);
  for (const std::uint32_t s : springs_at(particle)) look_at(w, other(s));
  std::size_t seen = particle / block;
  look_at_block(seen);
  for (const std::uint32_t s : springs_at(particle)) {
    if (other(s) / block != std::exchange(seen, other(s) / block)) look_at_block(seen);
  }
}

// What sum_up() and look_at() find, spring by spring.
void ListRates::look_at_all(std::span<const double> w) noexcept {
  std::fill(sums_.begin(), sums_.end(), Sums{});
  for (const JoinedPair& s : springs_) {
    for (const std::uint32_t i : {s.a, s.b}) add(sums_[i], s);
  }
  std::fill(of_particle_.begin(), of_particle_.end(), Most{});
  for (const JoinedPair& s : springs_) {
    if (s.is_broken) continue;
    const Most both = most_of(s, w);
    take_most(of_particle_[s.a], both);
    take_most(of_particle_[s.b], both);
  }
  for (std::size_t n = 0; n < of_block_.size(); ++n) look_at_block(n);
}

void ListRates::set_mass(std::span<const double> w, std::size_t particle) noexcept { look_around(w, particle); }

void ListRates::set_broken(std::span<const double> w, std::uint32_t spring, bool is_broken) noexcept {
  springs_[spring].is_broken = is_broken;
  for (const std::size_t i : {springs_[spring].a, springs_[spring].b}) sum_up(i);
  for (const std::size_t i : {springs_[spring].a, springs_[spring].b}) look_around(w, i);
}

void ListRates::set_stiffness(std::span<const double> w, const SourceRange& of, const Scalars& k, double c) noexcept {
  for (JoinedPair& s : springs_) {
    if (!of.holds(s)) continue;
    s.k = k[s.source - of.first];
    s.c = c;
  }
  look_at_all(w);
}

ListRates::Most ListRates::most() const noexcept {
  Most most;
  for (const Most& of : of_block_) take_most(most, of);
  return most;
}

}  // namespace dvdx
