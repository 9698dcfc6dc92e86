// A grid in sweeps, or a list that is a sheet: bands of rows, in each of which strands are swept one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "springs/sweep/sweep_form.hpp"
#include "springs/sweep/sweep_step.hpp"
#include "topology/list_sheet.hpp"

namespace dvdx {

template <class T>
class StrandsForm : public SweepForm<T> {
 public:
  // Each refers to `columns`, which must live as long. w: the working column of inverse masses.
  StrandsForm(const NetworkInput& in, const Grid& grid, std::size_t sheet_rows, const T* w, Columns<T>& columns);
  StrandsForm(const NetworkInput& in, const ListSheet& sheet, Columns<T>& columns);

  // Bands of even number come first: no two of them share a particle. The backward sweep has just the opposite order, so that
  // each odd band goes through both sweeps while it is in cache. its: the terms, or those of the start, in a workspace.
  void sweep(SweepStep<T>& step, const SweepTerms<T>& its) const noexcept;
  [[nodiscard]] std::size_t sheets() const noexcept { return sheets_.size() - 1; }
  [[nodiscard]] SweepRoom sweep_room(bool may_share_work) const noexcept;

  [[nodiscard]] bool has_lines() const noexcept { return !lines_.empty(); }
  [[nodiscard]] std::optional<LineForces> line_forces() const noexcept { return lines_.forces; }
  void set_line_forces(LineForces forces) noexcept { lines_.forces = forces; }

  void reserve_edits(const NetworkInput& in, const Memory& memory);
  void set_mass(const NetworkInput& in, std::size_t particle, const T* w) noexcept;
  void set_spring(const NetworkInput& in, std::size_t spring) noexcept;
  void set_springs(const NetworkInput& in) noexcept;
  void tear(const NetworkInput& in, const GridSpring& spring) noexcept;
  void set_step(const NetworkInput& in, Solves springs) noexcept;

  [[nodiscard]] std::string description() const;
  [[nodiscard]] std::size_t bytes() const noexcept;

 private:
  // The source of a lane's coefficients: all 0 if it has no spring, k and c 0 if that is torn. Such a lane moves nothing.
  struct LaneSource {
    double k = 0, c = 0;  // N/m, kg/s
    double w = 0;         // 1/kg of both ends, each as T holds it
    bool operator==(const LaneSource&) const = default;
  };
  // Rows [first, end) of a sheet.
  struct Rows {
    std::size_t first, end;
  };

  void lay_out(const NetworkInput& in, std::size_t rows, std::size_t columns, std::size_t sheet_rows);
  void add_strands(const ParticleOrder& order, std::size_t columns_of_sheet, const Rows& sheet, std::size_t family,
                   const Rows& rows);
  void place_springs(const NetworkInput& in);
  void drop_empty();
  [[nodiscard]] std::vector<Material<T>> materials_by(const Implicitness& of) const;
  [[nodiscard]] T inverse_of(const Implicitness& of, const Strand& strand, double w) const noexcept;
  [[nodiscard]] const T* inverses_by(const Implicitness& of, const T* w, Columns<T>& columns) const;
  static LaneSource source_of(const NetworkInput& in, std::size_t spring) noexcept;
  // Writes coefficients of lanes first, first + 1, ...
  void write_lanes(const NetworkInput& in, std::size_t first, std::span<const LaneSource> lanes) noexcept;
  void solve_lines(const SweepStep<T>& step, const SweepTerms<T>& its) const noexcept;
  void solve_lines(const SweepStep<T>& step, const SweepTerms<T>& its, std::size_t family, Visit visit,
                   std::size_t sheet) const noexcept;

  std::vector<Strand> strands_;
  std::vector<std::size_t> bands_;         // first strand of each band, and one more: bands two apart share no particle
  std::vector<std::size_t> sheets_;        // first band of each sheet, and one more: sheets share none
  std::vector<GridDirection> directions_;  // by Strand::material
  SheetLines lines_;                       // empty where the sweeps have none
  std::size_t springs_ = 0;                // columns of lambda

  // For a grid.
  std::vector<Material<T>> materials_, materials_of_start_;
  std::size_t row_ = 0;  // particles
  double damping_ = 0;

  // For a list.
  std::vector<std::uint32_t> spring_at_;  // the spring of each lane, or no_spring
  std::vector<std::uint32_t> lane_of_;    // of each spring, once it is changed
  std::vector<LaneSource> sources_;       // of each lane, likewise
};

extern template class StrandsForm<float>;
extern template class StrandsForm<double>;

}  // namespace dvdx
