// The contents of a report. Plain values: measured in one place, shown in others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dvdx/isa.hpp"
#include "dvdx/method.hpp"
#include "state/engine.hpp"

namespace dvdx::tool::report {

struct Errors {             // over particles and sample times
  double position_rms = 0;  // m
  double position_max = 0;  // m
  double velocity_rms = 0;  // m/s
  double relative = 0;      // position_rms over the amplitude
  double energy_drift = 0;  // over the energy scale
  bool diverged = false;
  std::size_t bad_particles = 0;
};

struct Timing {
  double ns_per_particle_step = 0;
  std::uint64_t steps = 0;  // of one repeat
  int repeats = 0;
  bool whole_run = true;  // else pieces from several moments of the run
};

struct Coupled {  // how networks were stepped
  std::string scheme;
  std::string method;
  std::string sweep, axis;  // empty where the scheme has none
  std::optional<double> theta;
};

// A value of a run that can be compared beyond the horizon.
struct BeyondValue {
  double value = 0;
  double off = 0;  // from the mean, in spreads as many starts show them
  bool agrees = true;
};

struct Run {
  std::string method;  // or, of networks, the scheme and what it takes: what the runs of a curve have in common
  bool is_baseline = false;
  Precision precision = Precision::float64;
  double step = 0;  // s
  std::uint64_t steps = 0;
  int substeps = 1;  // of a step
  std::optional<Coupled> coupled{};
  std::string isa;
  int threads = 1;
  std::string layout;
  std::string arithmetic;
  Errors errors;
  Timing timing;
  bool is_ranked = true;              // false where the error is no more than what chaos makes of any
  std::vector<BeyondValue> beyond{};  // a statistic each
  bool in_fit = false;
  std::optional<double> order;  // fitted, the same for all runs of a method and precision

  [[nodiscard]] double ns_per_particle_second() const { return timing.ns_per_particle_step / step; }
  [[nodiscard]] double substep() const { return step / substeps; }  // s
};

// The order that a method should have here, and the one that it has.
struct Order {
  std::string method;
  Precision precision = Precision::float64;
  std::optional<double> fitted;
  std::optional<double> theory;
  std::string note;  // "exact", or why there is no theory
};

// Joined particles may be chaotic: a difference of the start, however small, grows until two runs have nothing but their
// statistics in common. Positions are compared until the horizon alone.
struct Horizon {
  double seconds = 0;  // the whole duration where nothing ends it before
  bool is_whole = true;
  bool by_growth = false;  // it ends where a difference of the start has grown too much, else where the reference is in doubt
  double growth = 1;       // of a small difference of the start until then
  double nudge = 0;        // m: that difference, root mean square; 0 where none was tried
};

// Where a reference comes from: a formula for the whole run, exact motions from impact to impact, or the library's own kernel
// at finer steps, in which an error of the law itself would not show.
enum class ReferenceSource { formula, impacts, finer_steps };

struct ReferenceFacts {
  std::string kind;  // closed_form or extrapolated
  ReferenceSource source = ReferenceSource::formula;
  std::uint64_t most_impacts = 0;  // of one particle, from impact to impact
  std::string no_closed_form{};    // of finer steps: why there is no other, where that is known
  double self_error = 0;           // m, root mean square
  double step = 0;                 // s, of an extrapolated one
  int substeps = 1;                // of its step
  bool settled = true;             // an extrapolated one moved less than a hundredth of the smallest error shown
  Horizon horizon{};
};

struct Statistic {
  std::string name;
  std::string unit;  // "" where it has none
  double mean = 0;
  double spread = 0;  // standard deviation from start to start
};

// The scene beyond the horizon: runs by scheme fourth_order in float64 from starts beside its own.
struct Beyond {
  int starts = 0;       // 0: nothing is compared
  double nudge = 0;     // m, along each axis, by which they lie beside
  double apart = 0;     // m: the farthest that two of them come apart, root mean square over particles
  double most_off = 0;  // a run whose statistic lies farther off is of another kind: one in a hundred does by chance
  std::vector<Statistic> statistics{};
};

struct LeftOut {  // a curve or a run that was not measured
  std::string method;
  Precision precision = Precision::float64;
  std::string why;
};

struct GrowthCurve {
  std::vector<double> times;   // s
  std::vector<double> growth;  // of a small difference of the start
};

struct EnergyCurve {
  std::string method;
  std::vector<double> times;   // s
  std::vector<double> energy;  // J
};

struct LongRun {
  std::string method;
  double z = 0;  // Omega h
  std::uint64_t steps = 0;
  double measured = 0;    // E/E0, both averaged over periods
  double by_matrix = 0;   // determinant of the step's matrix to the power of the steps
  double by_formula = 0;  // the same from the series
  std::string formula;    // det = ...
  std::string verdict;    // conserves, grows, damps
  bool agrees = false;    // within 1 %
  std::vector<std::uint64_t> curve_steps;
  std::vector<double> curve;  // E/E0 on the way
};

struct Claim {
  std::string claim;
  std::string where;
  std::string expected;
  double measured = 0;
  std::string verdict;
};

// The scene's start with another number of particles, at its own step and by its own methods.
struct Throughput {
  Precision precision = Precision::float64;
  std::size_t particles = 0;
  std::size_t state_bytes = 0;       // of all particles
  std::uint64_t steps_per_call = 0;  // a block of particles stays in the nearest cache for all steps of a call
  double ns_per_particle_step = 0;
  int repeats = 0;
};

struct SceneReport {
  std::string scene;
  std::string path;
  std::string about;
  std::size_t particles = 0;
  std::size_t error_particles = 0;
  double step = 0;
  double duration = 0;
  std::vector<double> sample_times;
  ReferenceFacts reference;
  GrowthCurve growth{};  // empty where none was looked for
  Beyond beyond{};
  std::string no_beyond{};     // why there is nothing, where there might be
  double amplitude = 0;        // m, until the horizon
  double whole_amplitude = 0;  // m, of the whole run
  double energy_scale = 0;     // J
  bool keeps_energy = false;   // nothing in the scene takes or gives any
  std::vector<Run> runs;
  std::vector<LeftOut> left_out{};
  std::vector<Order> orders;
  std::vector<EnergyCurve> energy_curves;  // float64, at the scene's own step; the reference's first
  std::vector<LongRun> long_run;
  std::vector<Claim> claims;
  std::vector<Throughput> throughput{};  // of scenes whose particles nothing joins
};

struct Cache {  // of data
  int level = 1;
  std::size_t bytes = 0;
  int processors = 1;  // that share it
};

struct Machine {
  std::string cpu;
  int cores = 1;
  int threads = 1;
  std::string isa;
  std::vector<std::string> isas;
  std::string system;
  std::string compiler;
  std::string flags;
  std::string version;
  std::string date;
  std::vector<Cache> caches{};  // from the nearest on; none where the system does not progress
};

struct Report {
  Machine machine;
  std::vector<SceneReport> scenes;
};

enum class Effort { full, quick };

}  // namespace dvdx::tool::report
