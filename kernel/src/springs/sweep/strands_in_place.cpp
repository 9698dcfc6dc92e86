#include "springs/sweep/strands_in_place.hpp"

#include <span>

namespace dvdx {
namespace {

template <class T>
LaneSource source_of(const NetworkInput& in, const ListRates& springs, std::size_t s) noexcept {
  const auto [a, b] = springs.ends(s);
  return lane_source<T>(in, a, b, springs.pulls()[s], springs.drags()[s]);
}

}  // namespace

template <class T>
StrandsInPlace<T>::StrandsInPlace(const StrandsForm<T>& form, const NetworkInput& in, const ListRates& springs)
    : lane_of_(springs.size()), of_lane_(form.springs) {
  for (std::size_t lane = 0; lane < form.springs; ++lane) {
    const std::uint32_t s = form.spring_at[lane];
    if (s == no_spring) continue;
    lane_of_[s] = static_cast<std::uint32_t>(lane);
    of_lane_[lane] = source_of<T>(in, springs, s);
  }
}

template <class T>
void StrandsInPlace<T>::set_spring(StrandsForm<T>& form, const NetworkInput& in, const ListRates& springs,
                                   std::size_t spring) noexcept {
  const std::uint32_t lane = lane_of_[spring];
  of_lane_[lane] = source_of<T>(in, springs, spring);
  write_lanes(form, in, lane, std::span<const LaneSource>(of_lane_).subspan(lane, 1));
}

template <class T>
void StrandsInPlace<T>::set_springs(StrandsForm<T>& form, const NetworkInput& in, const ListRates& springs) noexcept {
  for (std::size_t s = 0; s < lane_of_.size(); ++s) of_lane_[lane_of_[s]] = source_of<T>(in, springs, s);
  write_lanes<T>(form, in, 0, of_lane_);
}

template <class T>
void StrandsInPlace<T>::set_scheme(StrandsForm<T>& form, const NetworkInput& in) noexcept {
  dvdx::set_scheme(form, in);
  write_lanes<T>(form, in, 0, of_lane_);
}

template class StrandsInPlace<float>;
template class StrandsInPlace<double>;

}  // namespace dvdx
