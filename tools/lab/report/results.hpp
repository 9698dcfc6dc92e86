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
  double relative = 0;      // position_rms divided by the amplitude
  double energy_drift = 0;  // relative to the energy scale
  bool diverged = false;
  std::size_t bad_particles = 0;
};

struct Timing {
  double ns_per_particle_step = 0;
  std::uint64_t steps = 0;  // of one repeat
  int repeats = 0;
  bool whole_run = true;  // false: pieces from several moments of the run
};

struct Coupled {  // the way in which networks were stepped
  std::string scheme;
  std::string method;
  std::string sweep, axis;  // empty if the scheme has none
  std::optional<double> theta;
};

// A value of a run that is comparable beyond the horizon.
struct BeyondValue {
  double value = 0;
  double off = 0;  // difference from the mean, in units of the spread expected with this number of starts
  bool agrees = true;
};

struct Run {
  std::string method;  // for networks: the scheme and its settings; the runs of a curve share it
  bool is_baseline = false;
  Precision precision = Precision::float64;
  double step = 0;  // s
  std::uint64_t steps = 0;
  int substeps = 1;  // in a step
  std::optional<Coupled> coupled{};
  std::string isa;
  int threads = 1;
  std::string layout;
  std::string arithmetic;
  Errors errors;
  Timing timing;
  bool is_ranked = true;              // false if the error is no larger than chaos makes any run's
  std::vector<BeyondValue> beyond{};  // one for each statistic
  bool in_fit = false;
  std::optional<double> order;  // fitted; the same for all runs of a method and precision

  [[nodiscard]] double ns_per_particle_second() const { return timing.ns_per_particle_step / step; }
  [[nodiscard]] double substep() const { return step / substeps; }  // s
};

// The order that a method should have here, and the fitted one.
struct Order {
  std::string method;
  Precision precision = Precision::float64;
  std::optional<double> fitted;
  std::optional<double> theory;
  std::string note;  // "exact", or the reason why there is no theory
};

// Joined particles may be chaotic: any difference of the start grows until two runs share only their statistics. Positions are
// therefore compared until the horizon only.
struct Horizon {
  double seconds = 0;  // the whole duration unless something ends it before
  bool is_whole = true;
  bool by_growth = false;  // it ended by the growth of a difference of the start; otherwise by doubt about the reference
  double growth = 1;       // growth of a small difference of the start until then
  double nudge = 0;        // m: that difference, root mean square; 0 if none was tried
};

// The source of a reference: a formula for the whole run, exact motions from impact to impact, or the library's own kernel at
// finer steps. The last one would not show an error of the law itself.
enum class ReferenceSource { formula, impacts, finer_steps };

struct ReferenceFacts {
  std::string kind;  // closed_form or extrapolated
  ReferenceSource source = ReferenceSource::formula;
  std::uint64_t most_impacts = 0;  // maximum over particles, for ReferenceSource::impacts
  std::string no_closed_form{};    // for finer steps: the reason why there is no other, if known
  double self_error = 0;           // m, root mean square
  double step = 0;                 // s, for an extrapolated one
  int substeps = 1;                // in its step
  bool settled = true;             // an extrapolated one moved by less than a hundredth of the smallest error shown
  Horizon horizon{};
};

struct Statistic {
  std::string name;
  std::string unit;  // "" if it has none
  double mean = 0;
  double spread = 0;  // standard deviation from start to start
};

// The scene beyond the horizon: runs by scheme fourth_order in float64 from starts near its own.
struct Beyond {
  int starts = 0;       // 0: nothing is compared
  double nudge = 0;     // m along each axis, the size of the starts' displacement
  double apart = 0;     // m: the largest distance between two of them, root mean square over particles
  double most_off = 0;  // limit of a statistic's difference; one in a hundred runs of the same kind exceeds it by chance
  std::vector<Statistic> statistics{};
};

struct LeftOut {  // a curve or a run that was not measured
  std::string method;
  Precision precision = Precision::float64;
  std::string why;
};

struct GrowthCurve {
  std::vector<double> times;   // s
  std::vector<double> growth;  // growth of a small difference of the start
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
  double by_formula = 0;  // the same by the series
  std::string formula;    // det = ...
  std::string verdict;    // conserves, grows, damps
  bool agrees = false;    // within 1 %
  std::vector<std::uint64_t> curve_steps;
  std::vector<double> curve;  // E/E0 during the run
};

struct Claim {
  std::string claim;
  std::string where;
  std::string expected;
  double measured = 0;
  std::string verdict;
};

// The scene's start with another number of particles, at its own step and with its own methods.
struct Throughput {
  Precision precision = Precision::float64;
  std::size_t particles = 0;
  std::size_t state_bytes = 0;       // for all particles
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
  GrowthCurve growth{};  // empty if growth was not measured
  Beyond beyond{};
  std::string no_beyond{};     // the reason why `beyond` is empty, if it could have been measured
  double amplitude = 0;        // m, until the horizon
  double whole_amplitude = 0;  // m, of the whole run
  double energy_scale = 0;     // J
  bool keeps_energy = false;   // nothing in the scene takes or gives energy
  std::vector<Run> runs;
  std::vector<LeftOut> left_out{};
  std::vector<Order> orders;
  std::vector<EnergyCurve> energy_curves;  // float64, at the scene's own step; the reference comes first
  std::vector<LongRun> long_run;
  std::vector<Claim> claims;
  std::vector<Throughput> throughput{};  // only for scenes without joined particles
};

struct Cache {  // of data
  int level = 1;
  std::size_t bytes = 0;
  int processors = 1;  // processors that share it
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
  std::vector<Cache> caches{};  // from the nearest on; none if the system does not tell
};

struct Report {
  Machine machine;
  std::vector<SceneReport> scenes;
};

enum class Effort { full, quick };

}  // namespace dvdx::tool::report
