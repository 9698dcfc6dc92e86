#include "air/compiled_air.hpp"

#include <algorithm>
#include <utility>

#include "springs/form.hpp"
#include "topology/triangles.hpp"

namespace dvdx {
namespace {

const std::optional<Aerodynamics>& aerodynamics_of(const Network& network) {
  return std::visit([](const auto& of) -> const std::optional<Aerodynamics>& { return of.aerodynamics; }, network);
}

// W of a triangle is a ninth of the sum over its corners of the corner's inverse mass times its number of triangles.
constexpr double ninth = 1.0 / 9;

}  // namespace

bool meets_air(const Network& network) noexcept { return aerodynamics_of(network).has_value(); }
bool meets_air(const Scene& scene) noexcept {
  return std::any_of(scene.networks.begin(), scene.networks.end(), [](const Network& n) { return meets_air(n); });
}

template <class T>
Air<T>::Air(const Scene& scene, const Grid* grid, std::span<const double> w, const ParticleOrder& order, const Memory& memory)
    : columns_(memory) {
  if (grid != nullptr && order.phases == 1) {
    make_grid(*grid, w, order);
  } else {
    make_list(scene, w, order);
  }
}

template <class T>
std::size_t Air<T>::bytes() const noexcept {
  const std::size_t indices = a_.size() + b_.size() + c_.size() + slots_.size() + first_slot_.size();
  return columns_.bytes() + indices * sizeof(std::int32_t);
}

// ---- a sheet in rows ------------------------------------------------------------------------------------------------------

template <class T>
void Air<T>::make_grid(const Grid& grid, std::span<const double> w, const ParticleOrder& order) {
  networks_.push_back({*grid.aerodynamics, 0, 0});
  W_right_ = columns_.add(order.size, T(-1), column_margin);
  W_below_ = columns_.add(order.size, T(-1), column_margin);
  grid_ = {.rows = grid.rows, .columns = grid.columns, .pitch = order.pitch, .W_right = W_right_, .W_below = W_below_};
  count_ = 2 * (grid.rows - 1) * (grid.columns - 1);
  for (std::size_t row = 0; row + 1 < grid.rows; ++row) {
    std::fill_n(W_right_ + element(row, 0), grid.columns - 1, T(0));
    std::fill_n(W_below_ + element(row, 0), grid.columns - 1, T(0));
  }
  for (const Pair& ends : grid.broken) {
    if (const auto spring = spring_between(grid, ends)) tear({}, *spring);
  }
  refresh(w, 0, 0, std::max(grid.rows, grid.columns));
}

template <class T>
int Air<T>::triangles_at(std::size_t row, std::size_t column) const noexcept {
  const auto is_there = [&](const T* of, std::size_t up, std::size_t left) {
    return row >= up && column >= left && of[element(row - up, column - left)] >= T(0) ? 1 : 0;
  };
  return is_there(W_right_, 0, 0) + is_there(W_below_, 0, 0) + is_there(W_right_, 0, 1) + is_there(W_below_, 1, 0) +
         is_there(W_right_, 1, 1) + is_there(W_below_, 1, 1);
}

// Refreshes the triangles whose cells are not farther than `reach` from that of (row, column).
template <class T>
void Air<T>::refresh(std::span<const double> w, std::size_t row, std::size_t column, std::size_t reach) noexcept {
  const std::size_t to_row = std::min(grid_.rows - 1, row + reach + 1);
  const std::size_t to_column = std::min(grid_.columns - 1, column + reach + 1);
  const auto share = [&](std::size_t i, std::size_t j) { return triangles_at(i, j) * w[i * grid_.columns + j]; };
  for (std::size_t i = row - std::min(row, reach); i < to_row; ++i) {
    for (std::size_t j = column - std::min(column, reach); j < to_column; ++j) {
      const double across = share(i, j) + share(i + 1, j + 1);
      T& right = W_right_[element(i, j)];
      T& below = W_below_[element(i, j)];
      if (right >= T(0)) right = static_cast<T>((across + share(i, j + 1)) * ninth);
      if (below >= T(0)) below = static_cast<T>((across + share(i + 1, j)) * ninth);
    }
  }
}

template <class T>
void Air<T>::set_inverse_mass(std::span<const double> w, std::size_t particle) noexcept {
  refresh(w, particle / grid_.columns, particle % grid_.columns, 1);
}

template <class T>
void Air<T>::take_away(T* of, std::size_t row, std::size_t column) noexcept {
  T& W = of[element(row, column)];
  if (W < T(0)) return;
  W = T(-1);
  --count_;
}

// w: empty if everything is refreshed afterwards.
template <class T>
void Air<T>::tear(std::span<const double> w, const GridSpring& spring) noexcept {
  const auto [row, column, down, right] = spring;
  if (down == 0 && right == 1) {
    take_away(W_right_, row, column);
    if (row != 0) take_away(W_below_, row - 1, column);
  } else if (down == 1 && right == 0) {
    take_away(W_below_, row, column);
    if (column != 0) take_away(W_right_, row, column - 1);
  } else if (down == 1 && right == 1) {
    take_away(W_right_, row, column);
    take_away(W_below_, row, column);
  }
  if (!w.empty()) refresh(w, row, column, 2);
}

// ---- a list ---------------------------------------------------------------------------------------------------------------

template <class T>
void Air<T>::make_list(const Scene& scene, std::span<const double> w, const ParticleOrder& order) {
  std::vector<Triangle> all;
  std::vector<std::size_t> places;
  std::size_t size = 0;
  for (const Network& network : scene.networks) {
    if (!meets_air(network)) continue;
    const std::vector<Triangle> own = whole_triangles(network);
    for (std::size_t t = 0; t < own.size(); ++t) places.push_back(size + t);
    all.insert(all.end(), own.begin(), own.end());
    // One more than there are: a triangle with W below 0, for slots that are not used.
    const std::size_t end = size + (own.size() / slice + 1) * slice;
    networks_.push_back({*aerodynamics_of(network), size, end});
    size = end;
  }
  count_ = all.size();
  std::vector<double> share(w.size(), 0.0);
  for (const Triangle& t : all) {
    for (const std::uint32_t i : t) share[i] += w[i];
  }
  for (std::vector<std::int32_t>* corner : {&a_, &b_, &c_}) corner->assign(size, 0);
  W_ = columns_.add(size, T(-1));
  for (std::size_t t = 0; t < all.size(); ++t) {
    const auto [a, b, c] = all[t];
    const std::size_t at = places[t];
    a_[at] = static_cast<std::int32_t>(order.of[a]);
    b_[at] = static_cast<std::int32_t>(order.of[b]);
    c_[at] = static_cast<std::int32_t>(order.of[c]);
    W_[at] = static_cast<T>((share[a] + share[b] + share[c]) * ninth);
  }
  make_slots(all, places, order);
  list_ = {.a = a_.data(), .b = b_.data(), .c = c_.data(), .W = W_, .first_slot = first_slot_.data(), .slots = slots_.data()};
}

template <class T>
void Air<T>::make_slots(std::span<const Triangle> of, std::span<const std::size_t> places, const ParticleOrder& order) {
  std::vector<std::vector<std::int32_t>> at(order.size);
  for (std::size_t t = 0; t < of.size(); ++t) {
    for (const std::uint32_t i : of[t]) at[order.of[i]].push_back(static_cast<std::int32_t>(places[t]));
  }
  const auto none = static_cast<std::int32_t>(a_.size() - 1);
  for (std::size_t first = 0; first < order.size; first += slice) {
    first_slot_.push_back(static_cast<std::uint32_t>(slots_.size() / slice));
    std::size_t most = 0;
    for (std::size_t k = 0; k < slice; ++k) most = std::max(most, at[first + k].size());
    for (std::size_t n = 0; n < most; ++n) {
      for (std::size_t k = 0; k < slice; ++k) slots_.push_back(n < at[first + k].size() ? at[first + k][n] : none);
    }
  }
  first_slot_.push_back(static_cast<std::uint32_t>(slots_.size() / slice));
}

// visit(triangle) for the triangles at a particle, none of them torn, in the order of the list.
template <class T>
template <class Visit>
void Air<T>::for_each_triangle_at(std::size_t element, const Visit& visit) const {
  for (std::size_t s = first_slot_[element / slice]; s < first_slot_[element / slice + 1]; ++s) {
    const auto t = static_cast<std::size_t>(slots_[s * slice + element % slice]);
    if (W_[t] >= T(0)) visit(t);
  }
}

// Summed as in make_list(), so that both round alike.
template <class T>
double Air<T>::share_at(std::span<const double> w, std::size_t element, const ParticleOrder& order) const noexcept {
  const double own = w[*order.particle_at(element)];
  double share = 0;
  for_each_triangle_at(element, [&](std::size_t) { share += own; });
  return share;
}

template <class T>
void Air<T>::set_inverse_mass(std::span<const double> w, std::size_t particle, const ParticleOrder& order) noexcept {
  for_each_triangle_at(order.of[particle], [&](std::size_t t) {
    const auto share = [&](std::int32_t corner) { return share_at(w, static_cast<std::size_t>(corner), order); };
    W_[t] = static_cast<T>((share(a_[t]) + share(b_[t]) + share(c_[t])) * ninth);
  });
}

template <class T>
void Air<T>::tear(std::span<const double> w, const AirNetwork& of, const Pair& torn, const ParticleOrder& order) noexcept {
  const auto other = static_cast<std::int32_t>(order.of[torn[1]]);
  for_each_triangle_at(order.of[torn[0]], [&](std::size_t t) {
    const bool has_both = a_[t] == other || b_[t] == other || c_[t] == other;
    if (!has_both || t < of.first || t >= of.end) return;
    W_[t] = T(-1);
    --count_;
    for (const std::int32_t corner : {a_[t], b_[t], c_[t]}) {
      set_inverse_mass(w, *order.particle_at(static_cast<std::size_t>(corner)), order);
    }
  });
}

template class Air<float>;
template class Air<double>;

}  // namespace dvdx
