// Any springs, by owner: each particle sums its own, slot by slot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "springs/form.hpp"
#include "springs/sum/slots.hpp"

namespace dvdx {

template <class T>
class GraphForm : public FormBase<T> {
 public:
  static constexpr SpringsAct act = SpringsAct::in_pulses;

  // The form refers to `columns`, which must live as long. accumulate by `combined` is one filtered pulse, which treats each
  // pair as if it were alone: W = k (w_a + w_b).
  GraphForm(const NetworkInput& in, Columns<T>& columns);

  void kick(const NetworkKernels<T>& passes, const WorkColumns<T>& work, T pulse, std::size_t from, std::size_t to) const {
    passes.graph(terms_, work, pulse, from, to);
  }
  void accelerate(const NetworkKernels<T>& passes, const WorkColumns<T>& work, std::size_t from, std::size_t to) const {
    passes.graph_acceleration(terms_, work, from, to);
  }
  void damp(const NetworkKernels<T>& passes, const WorkColumns<T>& work, const DampingPass<T>& pass, std::size_t from,
            std::size_t to) const {
    passes.damp_graph(damped_, work, pass, from, to);
  }

  [[nodiscard]] Edited edited() const noexcept { return edited_; }
  void reserve_edits(const NetworkInput& in, const Memory& memory);
  [[nodiscard]] bool can_set_mass(const NetworkInput& in, std::size_t particle, double w) const noexcept;
  [[nodiscard]] bool can_set_zero_length() const noexcept { return true; }
  void set_spring(const NetworkInput& in, std::size_t spring) noexcept;
  void set_springs(const NetworkInput& in) noexcept;

  [[nodiscard]] std::string description() const { return "as a graph: each particle sums its own"; }
  [[nodiscard]] std::size_t bytes() const noexcept { return lists_.bytes() + damped_lists_.bytes(); }

 private:
  // The lanes of a spring in the slots of its first end and of its second, or nowhere.
  struct SpringLanes {
    static constexpr std::uint32_t nowhere = 0xffffffff;
    std::uint32_t a = nowhere, b = nowhere;
  };
  // The values of a spring's lanes.
  struct SlotValues {
    T k{}, kl{}, c{};
  };
  // The lanes of each spring of the list, and in the damping passes if these have slots of their own. Then the spring of each
  // lane: a lane without one has the index behind the last spring.
  struct Lanes {
    std::vector<SpringLanes> of, damped;
    std::vector<std::uint32_t> springs, damped_springs;
    std::vector<T> k, kl, c;  // of each spring, and of no spring: room to make them in
  };

  void add_damped_slots(const NetworkInput& all, Columns<T>& columns);
  static SlotValues values_of(double k, double l, double c, double q) noexcept;
  static SlotValues values_of(const JoinedPair& s) noexcept;
  static std::uint32_t lane_of(const GraphTerms<T>& terms, std::size_t owner, std::size_t neighbour, std::size_t nth);
  template <class IsThere>
  static std::vector<SpringLanes> lanes_of(const GraphTerms<T>& terms, const NetworkInput& in, const IsThere& is_there);
  static std::vector<std::uint32_t> springs_of(std::span<const SpringLanes> lanes, std::size_t slots);
  void make_values(const ListRates& springs) noexcept;
  void make_plain_values(const ListRates& springs) noexcept;
  void write_pulls() noexcept;

  GraphTerms<T> terms_, damped_;       // damped_: of a pulse's damping passes, the same slots, or where only some springs damp
  SlotLists lists_, damped_lists_;     // ... slots of their own
  Edited edited_ = Edited::by_spring;  // unless they accumulate
  std::optional<Lanes> lanes_;         // once it is changed
};

extern template class GraphForm<float>;
extern template class GraphForm<double>;

}  // namespace dvdx
