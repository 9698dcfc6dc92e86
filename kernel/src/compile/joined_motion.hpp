// What a scene's networks compile to: where the particles stand while they are stepped, their springs rounded, the flows
// between the springs' pulses, and the working memory of one state.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "compile/constraints.hpp"
#include "compile/free_motion.hpp"
#include "compile/limit.hpp"
#include "compile/particle_order.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "passes/network/network.hpp"

namespace dvdx {

struct Compliances {
  double kappa, eta, inverse;
};

template <class T>
class NetworkRun;

template <class T>
class NetworkProgram {
 public:
  // The scene and the options have been checked; start: the particles' positions.
  NetworkProgram(const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start);
  NetworkProgram(const NetworkProgram&) = delete;
  NetworkProgram& operator=(const NetworkProgram&) = delete;

  // Where the scene asks for fewer sub-steps than the start's springs allow.
  [[nodiscard]] std::optional<Error> refusal(Unstable unstable) const;

  // Makes the flows again and nothing else. False where the springs must be made again too: the program is then of no use.
  [[nodiscard]] bool replace_forces(const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start);

  // Of states kept in T, or in float32 and rests where T is float64.
  template <class Kept>
  StepResult step(State<Kept>& state, std::size_t steps, const ParallelFor& parallel) noexcept;

  // How the springs lie and who works them out.
  enum class Form {
    grid,     // rows: each spring once, by owner
    graph,    // slots: by owner
    pairs,    // slots: each pair's own contribution
    strands,  // a grid in sweeps
    colours,  // any springs in sweeps
  };
  [[nodiscard]] Form form() const noexcept { return form_; }
  [[nodiscard]] const NetworkLimit& limit() const noexcept { return limit_; }
  [[nodiscard]] const Coupling& coupling() const noexcept { return coupling_; }
  [[nodiscard]] double step_size() const noexcept { return h_; }  // s
  // What another scheme would need to be stable in any position.
  [[nodiscard]] int safe_substeps(const Coupling& other) const {
    return substeps_for(scheme_limit(other), h_, frequencies_.bound, frequencies_.damping);
  }
  [[nodiscard]] std::size_t springs() const noexcept { return spring_count_; }
  [[nodiscard]] std::size_t colours() const noexcept { return colours_.empty() ? 0 : colours_.size() - 1; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }
  [[nodiscard]] const ConstraintProgram<T>* constraints() const noexcept { return constraints_.get(); }

 private:
  friend class NetworkRun<T>;

  struct SlotColumns {
    T *k = nullptr, *kl = nullptr, *c = nullptr;
    T *A = nullptr, *B = nullptr, *C = nullptr, *D = nullptr, *l = nullptr, *linear = nullptr;
  };
  struct Held {
    std::uint32_t particle = 0, element = 0;
    std::array<T, 3> x{}, v{};  // of the state that is stepped
  };

  T* column(std::size_t size, T fill);
  std::array<T*, 3> columns(T fill);
  void make_sheet(const std::vector<std::size_t>& fixed);
  std::size_t flow_over(double part, const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start);
  void make_flows(const Scene& scene, const Options& options, Isa isa, const std::vector<Vec3>& start);
  void make_grid(const Grid& grid);
  void make_graph();
  void add_slot(std::size_t first, const auto& lanes, bool is_at_offset, const SlotColumns& to);
  void put_spring(const JoinedPair& s, double w, std::size_t lane, const SlotColumns& to) const;
  void make_sweeps();
  [[nodiscard]] Compliances compliances(double k, double c, double w) const;
  void keep_sweeps(std::size_t springs);
  void make_strands(const Grid& grid);
  void add_strands(const Grid& grid, const GridDirection& d, std::size_t family, std::size_t from, std::size_t to,
                   std::size_t& springs);
  void make_colours();
  [[nodiscard]] double substep() const noexcept { return h_ / limit_.substeps; }

  Coupling coupling_;
  double h_;       // s, the step
  Memory source_;  // of the columns
  const NetworkKernels<T>* kernels_;
  std::vector<JoinedPair> pairs_;  // only while the program is made
  std::size_t spring_count_;
  std::size_t particles_;
  std::vector<double> w_;  // 1/kg
  Splitting splitting_;
  Frequencies frequencies_;
  NetworkLimit limit_;

  Form form_ = Form::graph;
  Places places_;
  std::vector<AlignedArray<T>> memory_;
  std::size_t bytes_ = 0;
  Sheet<T> sheet_;
  std::array<T*, 3> origin_{};
  bool is_relative_ = false;  // positions are counted from the step's start
  std::vector<Held> fixed_;   // by element

  std::vector<std::unique_ptr<Program<T>>> flows_;
  std::vector<double> durations_;           // s, of each flow
  std::vector<std::size_t> first_, again_;  // flow before each pulse of the first sub-step, and of the others
  std::optional<std::size_t> last_;         // flow after the last pulse of the step

  GridTerms<T> grid_;
  GraphTerms<T> graph_;
  std::vector<std::uint32_t> first_slot_;
  std::vector<Slot> slots_;
  std::vector<std::int32_t> indices_;

  SweepTerms<T> sweep_;
  std::vector<Strand> strands_;
  std::vector<StrandFamily<T>> families_;
  std::vector<std::size_t> bands_;  // first strand of each band, and one more: bands two apart share no particle
  std::vector<std::int32_t> a_, b_;
  std::vector<std::size_t> colours_;  // first spring of each colour, a multiple of 16, and one more
  T shift_to_x_{}, shift_to_v_{};

  std::unique_ptr<ConstraintProgram<T>> constraints_;  // null without

  std::atomic_flag is_stepping_ = ATOMIC_FLAG_INIT;
};

extern template class NetworkProgram<float>;
extern template class NetworkProgram<double>;

}  // namespace dvdx
