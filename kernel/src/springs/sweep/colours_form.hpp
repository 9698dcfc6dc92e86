// Any springs in sweeps, in colours. Once they are changed in place, the coefficients of each 16 stand in memory of their own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "springs/sweep/colour_layout.hpp"
#include "springs/sweep/sweep_form.hpp"
#include "springs/sweep/sweep_step.hpp"

namespace dvdx {

template <class T>
class ColoursForm : public SweepForm<T> {
 public:
  static constexpr bool has_records = true;

  // The form refers to `columns`, which must live as long.
  ColoursForm(const NetworkInput& in, Columns<T>& columns);

  // The springs between pieces are swept first and last. Each piece goes through both sweeps while it is in cache, as springs
  // of different pieces share no particle. its: the terms, or those of the start, in a workspace.
  void sweep(SweepStep<T>& step, const SweepTerms<T>& its) const noexcept;
  [[nodiscard]] SweepRoom sweep_room(bool may_share_work) const noexcept;
  [[nodiscard]] bool has_lines() const noexcept { return !lines_.empty(); }

  void reserve_edits(const NetworkInput& in, const Memory& memory);
  [[nodiscard]] bool can_set_mass(const NetworkInput& in, std::size_t particle, double w) const noexcept;
  void set_mass(const NetworkInput& in, std::size_t particle, const T* w) noexcept;
  void set_spring(const NetworkInput& in, std::size_t spring) noexcept;
  void set_springs(const NetworkInput& in) noexcept;
  void set_step(const NetworkInput& in, Solves springs) noexcept;

  [[nodiscard]] std::string description() const;
  [[nodiscard]] std::size_t bytes() const noexcept;

 private:
  static constexpr std::size_t set_size = coefficient_sets * slice;
  // The source of the coefficients of 16 springs. A lane with no spring, or with a torn one, has k = c = 0.
  struct Source {
    std::array<double, slice> k{}, c{}, w_a{}, w_b{};
    bool operator==(const Source&) const = default;
  };
  struct Edits {
    static constexpr std::uint32_t nowhere = 0xffffffff;
    std::vector<std::uint32_t> lane_of;  // of each spring, or nowhere: between fixed ends
    // There are as many sets as groups of 16 springs, so that a group that leaves a shared set finds a free one.
    std::vector<std::uint32_t> set_of, users, free;
    std::vector<Source> sources;
    std::vector<std::uint8_t> is_made;  // of each set, while all are made again
    AlignedArray<T> on, start;          // of each set; the latter of generalized alpha

    [[nodiscard]] std::uint32_t set_of_its_own(std::size_t group) noexcept;
    void leave(std::size_t group, const Source& source) noexcept;
  };

  void read_lane(const NetworkInput& in, std::size_t spring, std::size_t lane, Source& source) const noexcept;
  [[nodiscard]] Source source_of(const NetworkInput& in, std::size_t group) const noexcept;
  static void write(const Implicitness& of, const Source& source, T* set) noexcept;
  // Returns the sets of coefficients of all springs, equal ones once. places: the position of the sets of each 16 springs.
  [[nodiscard]] const T* sets_by(const NetworkInput& in, const Implicitness& of, std::vector<std::uint32_t>& places,
                                 Columns<T>& columns) const;
  void copy_group(std::size_t group) noexcept;
  void write(const SweepImplicitness& of, std::uint32_t set) noexcept;

  void solve_lines(const SweepStep<T>& step, const SweepTerms<T>& its) const noexcept;
  void fill_records(SweepStep<T>& step, const SweepTerms<T>& its) const noexcept;

  ColourLayout layout_;
  std::vector<std::uint32_t> coefficients_of_, coefficients_of_start_;  // the terms point to these
  ListLines lines_;                                                     // empty where the sweeps have none
  std::optional<Edits> edits_;
};

extern template class ColoursForm<float>;
extern template class ColoursForm<double>;

}  // namespace dvdx
