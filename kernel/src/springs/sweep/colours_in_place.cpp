#include "springs/sweep/colours_in_place.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>

#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {

template <class T>
ColoursInPlace<T>::ColoursInPlace(const ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs,
                                  const Memory& memory)
    : spring_at_(form.spring_at), lane_of_(springs.size(), nowhere), is_turned_(springs.size(), false) {
  place(form, in, springs);
  const std::size_t groups = form.springs / slice;
  users_.assign(groups, 0);
  is_made_.assign(groups, 0);
  sources_.resize(groups);
  std::unordered_map<std::string, std::uint32_t> known;
  for (std::size_t group = 0; group < groups; ++group) {
    const Source source = source_of(in, springs, group);
    const std::string bytes(reinterpret_cast<const char*>(&source), sizeof(source));
    const auto [found, is_new] = known.try_emplace(bytes, static_cast<std::uint32_t>(known.size()));
    if (is_new) sources_[found->second] = source;
    set_of_.push_back(found->second);
    ++users_[found->second];
  }
  free_.reserve(groups);
  for (std::size_t set = known.size(); set < groups; ++set) free_.push_back(static_cast<std::uint32_t>(set));
  on_ = aligned_array<T>(groups * set_size, memory);
  if (form.alpha) start_ = aligned_array<T>(groups * set_size, memory);
  for (std::uint32_t set = 0; set < known.size(); ++set) write(scheme_of(in), set);
}

template <class T>
void ColoursInPlace<T>::place(const ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs) {
  for (std::size_t lane = 0; lane < form.springs; ++lane) {
    const std::uint32_t spring = form.spring_at[lane];
    if (spring == no_spring) continue;
    lane_of_[spring] = static_cast<std::uint32_t>(lane);
    is_turned_[spring] = form.a[lane] != record * in.order.of[springs.ends(spring).a];
  }
}

template <class T>
void ColoursInPlace<T>::take_over(ColoursForm<T>& form) noexcept {
  form.terms.ranges.coefficients = on_.get();
  if (form.alpha) form.alpha->sweeps_of_start.ranges.coefficients = start_.get();
  for (std::size_t group = 0; group < set_of_.size(); ++group) tell(form, group);
}

template <class T>
void ColoursInPlace<T>::tell(ColoursForm<T>& form, std::size_t group) noexcept {
  const auto place = static_cast<std::uint32_t>(set_of_[group] * set_size);
  form.coefficients_of[group] = place;
  if (form.alpha) form.coefficients_of_start[group] = place;
}

template <class T>
void ColoursInPlace<T>::read_lane(const NetworkInput& in, const ListRates& springs, std::size_t spring, std::size_t lane,
                                  Source& source) const noexcept {
  auto [a, b] = springs.ends(spring);
  if (is_turned_[spring]) std::swap(a, b);
  source.k[lane] = springs.pulls()[spring];
  source.c[lane] = springs.drags()[spring];
  source.w_a[lane] = in.w[a];
  source.w_b[lane] = in.w[b];
}

template <class T>
auto ColoursInPlace<T>::source_of(const NetworkInput& in, const ListRates& springs, std::size_t group) const noexcept
    -> Source {
  Source source;
  for (std::size_t lane = 0; lane < slice; ++lane) {
    const std::uint32_t spring = spring_at_[group * slice + lane];
    if (spring != no_spring) read_lane(in, springs, spring, lane, source);
  }
  return source;
}

template <class T>
void ColoursInPlace<T>::write(const Implicitness& of, std::uint32_t set, T* coefficients) noexcept {
  T* const to = coefficients + set * set_size;
  const Source& source = sources_[set];
  for (std::size_t lane = 0; lane < slice; ++lane) {
    const Compliances made = compliances(of, source.k[lane], source.c[lane], source.w_a[lane] + source.w_b[lane]);
    const std::array of_lane{made.kappa, made.eta, made.inverse, source.w_a[lane], source.w_b[lane]};
    for (std::size_t n = 0; n < coefficient_sets; ++n) to[n * slice + lane] = static_cast<T>(of_lane[n]);
  }
}

template <class T>
void ColoursInPlace<T>::write(const Scheme& scheme, std::uint32_t set) noexcept {
  write(scheme.on, set, on_.get());
  if (start_.get() != nullptr) write(scheme.start, set, start_.get());
}

template <class T>
auto ColoursInPlace<T>::scheme_of(const NetworkInput& in) noexcept -> Scheme {
  return {implicitness(in), implicitness_of_start(in)};
}

template <class T>
std::uint32_t ColoursInPlace<T>::set_of_its_own(std::size_t group) noexcept {
  std::uint32_t& set = set_of_[group];
  if (users_[set] == 1) return set;
  --users_[set];
  set = free_.back();
  free_.pop_back();
  users_[set] = 1;
  return set;
}

template <class T>
void ColoursInPlace<T>::set_spring(ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs,
                                   std::size_t spring) noexcept {
  const std::size_t group = lane_of_[spring] / slice;
  Source source = sources_[set_of_[group]];
  read_lane(in, springs, spring, lane_of_[spring] % slice, source);
  const std::uint32_t set = set_of_its_own(group);
  sources_[set] = source;
  write(scheme_of(in), set);
  tell(form, group);
}

// Groups that share a set go on sharing it where their springs have changed alike.
template <class T>
void ColoursInPlace<T>::set_springs(ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs) noexcept {
  const Scheme scheme = scheme_of(in);
  std::fill(is_made_.begin(), is_made_.end(), std::uint8_t{0});
  for (std::size_t group = 0; group < set_of_.size(); ++group) {
    const std::uint32_t shared = set_of_[group];
    const Source source = source_of(in, springs, group);
    const bool is_first = std::exchange(is_made_[shared], std::uint8_t{1}) == 0;
    if (sources_[shared] == source) continue;
    if (!is_first) leave(group, source);
    const std::uint32_t set = set_of_[group];
    tell(form, group);
    is_made_[set] = 1;
    sources_[set] = source;
    write(scheme, set);
  }
}

// For that of the group before where it is what it needs, else for a free one.
template <class T>
void ColoursInPlace<T>::leave(std::size_t group, const Source& source) noexcept {
  const std::uint32_t before = set_of_[group - 1];
  if (sources_[before] != source) {
    (void)set_of_its_own(group);
    return;
  }
  --users_[set_of_[group]];
  ++users_[before];
  set_of_[group] = before;
}

template <class T>
void ColoursInPlace<T>::set_scheme(ColoursForm<T>& form, const NetworkInput& in) noexcept {
  dvdx::set_scheme(form, in);
  const Scheme scheme = scheme_of(in);
  for (std::uint32_t set = 0; set < users_.size(); ++set) {
    if (users_[set] != 0) write(scheme, set);
  }
}

template class ColoursInPlace<float>;
template class ColoursInPlace<double>;

}  // namespace dvdx
