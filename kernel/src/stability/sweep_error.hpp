// How much softer sweeps leave springs than they are, and how long a sub-step may be for that. It is made from the springs, the
// masses and the steady accelerations alone, in a fixed order of + - * / and sqrt, so that every machine finds the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"
#include "springs/frequencies.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "topology/particle_order.hpp"
#include "topology/topology.hpp"

namespace dvdx {

// The part of its side that a net may hang too low, or be off in motion.
inline constexpr double most_sweep_error = 0.01;

[[nodiscard]] double share_of_side(const SweepEstimate& estimate) noexcept;

// A net under its load, as sweeps find it. Torn springs count as whole: a sheet that tears keeps its sub-steps.
class SweptNet {
 public:
  // For a scene that is one sheet. If all its particles are alike, no memory grows with the sheet. Held particles stand where
  // they do in the flat sheet.
  SweptNet(const Scene& scene, const Grid& sheet);
  // w: 1/kg of each particle, 0 where fixed or kinematic; start: the particles' positions; swept: the springs' walk in sweeps.
  SweptNet(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const double> w, std::span<const Vec3> start,
           Walk swept);

  // Returns the estimate of the worst piece. frequency: rad/s, the bound of the springs', as rho_of() takes it.
  [[nodiscard]] SweepEstimate estimate(const Coupling& coupling, double frequency, const SubstepLength& substep) const;
  // Returns the longest sub-step that keeps most_sweep_error, or leapfrog's if that is longer; infinity if nothing hangs. It is
  // one of sixteen rungs a factor of two, or leapfrog's, so that the sub-steps of every step follow from it alone.
  [[nodiscard]] double longest_substep(const Coupling& coupling, const HighestRates& rates) const;

  // Return SweepEstimate::turning of the worst piece, and the largest that comes to rest. longest: s, a sub-step.
  [[nodiscard]] double turning(const Coupling& coupling, double longest) const noexcept;
  [[nodiscard]] double most_turning() const noexcept;

  [[nodiscard]] SpringsAre springs_are() const noexcept { return springs_are_; }
  // Whether some of it comes to lie on surfaces. There it is sheared far more than it hangs, which the estimate does not see.
  [[nodiscard]] bool drapes() const noexcept { return drapes_; }

 private:
  struct Link {
    std::uint32_t a = 0, b = 0;
    double k = 0, l = 0;  // N/m, m
    double tension = 0;   // N, on the way from a to b
    std::uint32_t piece = 0;
    [[nodiscard]] std::uint32_t other(std::uint32_t end) const noexcept { return end == a ? b : a; }
  };
  // A spring in a forward and a backward sweep.
  struct Leak {
    double square = 0;       // N^2/kg^2: of (A_l^T tau)_i, by which the springs that are visited later part its ends
    double of_k = 0, w = 0;  // m/N, and 1/kg of both ends
    std::uint32_t piece = 0;
  };
  // Part of a piece between two held particles: a cable that sags, unless a triangle of springs is in its way.
  struct Span {
    double length = 0, slack = 0;  // m: between both, and how much longer the springs are at rest
    double load = 0;               // N, across
  };
  struct Piece {
    double side = 0;       // m
    double load = 0;       // N
    double energy = 0;     // J: sum of tension^2 / k
    Span span{};           // the tautest, if any
    double turning = 0;    // rad/s: how fast its springs turn under their tension
    bool is_line = false;  // its springs follow each other, and are solved at once if lines are
  };
  // Each particle's way to the particle that holds it.
  struct Ways {
    std::vector<double> distance;         // m, along the springs at rest to the held particle
    std::vector<std::uint32_t> held_by;   // the held particle
    std::vector<std::uint32_t> in_order;  // particles, by distance
    std::vector<double> carried;          // N
  };

  void take_sheet(const Scene& scene, const Grid& sheet);
  void add_links_of(const Grid& sheet, std::size_t rows, std::size_t columns, std::size_t stride);
  void order_by_colours();
  void load_up(const Scene& scene);
  void find_pieces();
  void find_lines();
  void list_links();
  [[nodiscard]] Ways find_ways(std::span<const std::uint32_t> from) const;
  void lay_down();
  void carry_loads(Ways& ways);
  void find_span(const Link& link, const Ways& ways);
  void leave_out_stiff_spans();
  void find_leaks();
  void find_turning();
  [[nodiscard]] static double sag(const Piece& piece, double work);
  [[nodiscard]] double left_of(const Piece& piece, const Coupling& coupling, const SubstepLength& substep) const;
  [[nodiscard]] std::vector<double> leaks(const Coupling& coupling, double T) const;

  Vec3 down_{};   // of length 1
  double g_ = 0;  // m/s^2
  SpringsAre springs_are_ = SpringsAre::in_rows;
  bool drapes_ = false;
  std::vector<double> w_;     // 1/kg
  std::vector<double> mass_;  // kg, for which a particle stands
  std::vector<Vec3> place_;   // m, read of held particles
  std::vector<Link> links_;   // in the order of a sweep
  std::vector<Piece> pieces_;
  std::vector<Leak> leaks_;
  std::vector<std::uint32_t> piece_of_;        // of each particle
  std::vector<std::uint32_t> first_, beside_;  // of each particle, its links
};

// The number of sub-steps of a step that are at most `longest` long.
[[nodiscard]] int substeps_within(double longest, double step) noexcept;

}  // namespace dvdx
