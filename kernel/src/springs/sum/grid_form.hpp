// A grid, each spring once, by rows.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "springs/form.hpp"

namespace dvdx {

template <class T>
class GridForm : public FormBase<T> {
 public:
  static constexpr SpringsAct act = SpringsAct::in_pulses;

  GridForm() = default;
  // The form refers to `columns`, which must live as long.
  GridForm(const NetworkInput& in, const Grid& grid, Columns<T>& columns);

  void kick(const NetworkKernels<T>& passes, const WorkColumns<T>& work, T pulse, std::size_t from, std::size_t to) const {
    passes.grid(terms_, work, pulse, from, to);
  }
  void accelerate(const NetworkKernels<T>& passes, const WorkColumns<T>& work, std::size_t from, std::size_t to) const {
    passes.grid_acceleration(terms_, work, from, to);
  }
  void damp(const NetworkKernels<T>& passes, const WorkColumns<T>& work, const DampingPass<T>& pass, std::size_t from,
            std::size_t to) const {
    passes.damp_grid(terms_, work, pass, from, to);
  }
  [[nodiscard]] std::size_t unit() const noexcept { return terms_.pitch; }
  [[nodiscard]] const GridTerms<T>* grid_terms() const noexcept { return &terms_; }

  [[nodiscard]] Edited edited() const noexcept { return Edited::by_row; }
  void reserve_torn(std::size_t row, Columns<T>& columns);
  void set_stiffness(const Grid& grid);
  void tear(const NetworkInput& in, const GridSpring& spring) noexcept;

  [[nodiscard]] std::string description() const { return "as a grid: each spring once, no index loaded"; }

 private:
  GridTerms<T> terms_;
  std::vector<const T*> whole_;  // the terms point to it if a spring is torn
};

extern template class GridForm<float>;
extern template class GridForm<double>;

}  // namespace dvdx
