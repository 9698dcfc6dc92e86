#include "springs/sum/grid_form.hpp"

namespace dvdx {
namespace {

// The index of a direction's line among those of a row of GridTerms::whole: in the order of GridFamilies.
std::size_t line_of(const GridSpring& spring) {
  if (spring.down == 0) return spring.right == 1 ? 0 : 1;
  return spring.down == 1 ? static_cast<std::size_t>(3 + spring.right) : 5;
}

}  // namespace

template <class T>
GridForm<T>::GridForm(const NetworkInput& in, const Grid& grid, Columns<T>& columns) {
  terms_.rows = grid.rows;
  terms_.columns = grid.columns;
  terms_.pitch = in.order.pitch;
  set_stiffness(grid);
  for (const Pair& ends : grid.broken) {
    const GridSpring spring = *spring_between(grid, ends);
    reserve_torn(spring.row, columns);
    tear(in, spring);
  }
}

template <class T>
void GridForm<T>::reserve_torn(std::size_t row, Columns<T>& columns) {
  if (whole_.empty()) whole_.resize(terms_.rows, nullptr);
  if (whole_[row] == nullptr) whole_[row] = columns.add(grid_directions * terms_.pitch, T(1), column_margin);
  terms_.whole = whole_.data();
}

template <class T>
void GridForm<T>::set_stiffness(const Grid& grid) {
  for (const GridDirection& d : directions_of(grid)) {
    Family<T> family{.k = static_cast<T>(d.k), .kl = static_cast<T>(d.k * d.l), .c = static_cast<T>(grid.damping)};
    if (!family.is_there()) family = {};  // k and c may round to 0 in T
    auto& along = terms_.along;
    if (d.down == 0) (d.right == 1 ? along.right : along.right2) = family;
    if (d.down == 1) (d.right < 0 ? along.left_below : (d.right == 0 ? along.below : along.right_below)) = family;
    if (d.down == 2) along.below2 = family;
  }
}

template <class T>
void GridForm<T>::tear(const NetworkInput& /*in*/, const GridSpring& spring) noexcept {
  const std::size_t column = spring.right < 0 ? spring.column - 1 : spring.column;
  const_cast<T*>(whole_[spring.row])[line_of(spring) * terms_.pitch + column] = T(0);  // our own memory
}

template class GridForm<float>;
template class GridForm<double>;

}  // namespace dvdx
