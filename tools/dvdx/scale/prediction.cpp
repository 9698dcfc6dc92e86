#include "scale/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "dvdx/partition.hpp"
#include "output/gnuplot.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

constexpr std::uint64_t most_joined = std::uint64_t{1} << 48U;

[[noreturn]] void refuse(const std::string& size, const char* valid) {
  throw Fault(Exit::usage, "--size " + size + ": must be " + valid);
}

std::optional<std::uint64_t> whole(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (!(number >= 1) || number > 1e15 || std::trunc(number) != number) return std::nullopt;
  return static_cast<std::uint64_t>(number);
}

bool is_damped(const Scene& scene) {
  return std::any_of(scene.networks.begin(), scene.networks.end(), [](const Network& network) {
    return std::visit([](const auto& springs) { return springs.damping != 0; }, network);
  });
}

Extent on_each(const Extent& extent, std::uint64_t ranks) {
  Extent all = extent;
  all.particles *= ranks;
  if (!all.sheet) return all;
  auto rows = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(ranks)));
  while (ranks % rows != 0) --rows;
  all.sheet->rows *= rows;
  all.sheet->columns *= ranks / rows;
  return all;
}

std::optional<double> least_time(const Extent& extent, std::uint64_t ranks, const HaloMessages& sent, const Machine& machine) {
  std::optional<double> least;
  for (const Cut& cut : cuts_of(extent, ranks)) {
    const double time = times_of(cut, sent, machine).all();
    least = std::min(least.value_or(time), time);
  }
  return least;
}

}  // namespace

Extent extent_of(const SceneFile& file, const std::string& size) {
  Extent extent{.particles = file.particles.count, .scene = &file.scene};
  if (const auto* grid = only_sheet(file.scene, extent.particles)) {
    extent.sheet = *grid;
  } else if (!file.scene.networks.empty()) {
    extent.list = &file.scene;
  }
  if (size.empty()) return extent;
  if (extent.list != nullptr) refuse(size, "left out: what the networks of this scene join is a list, which has one size");
  if (!extent.sheet) {
    const auto particles = whole(size);
    if (!particles) refuse(size, "a whole number of particles, such as 1e10");
    extent.particles = *particles;
    return extent;
  }
  const auto cross = size.find('x');
  const auto rows = whole(std::string_view(size).substr(0, cross));
  const auto columns = cross == std::string::npos ? std::nullopt : whole(std::string_view(size).substr(cross + 1));
  if (!rows || !columns || *rows < 2 || *columns < 2 || *rows > most_joined / *columns)
    refuse(size, "rows and columns of the sheet, such as 32768x32768");
  extent.sheet->rows = *rows;
  extent.sheet->columns = *columns;
  extent.particles = *rows * *columns;
  return extent;
}

namespace {

HaloMessages halo_of_springs(const SceneFile& file, std::size_t scalar_bytes) {
  if (file.scene.networks.empty()) return {};
  if (file.scene.coupling.scheme == Scheme::sequential) {
    return {.times = tellings_of_sweeps(file.scene, file.particles.count), .numbers = 3, .bytes = scalar_bytes};
  }
  const Coupling& coupling = file.scene.coupling;
  if (coupling.scheme == Scheme::accumulate) {
    return {.times = coupling.method == Method::combined ? 1U : 2U, .numbers = 3, .bytes = scalar_bytes};
  }
  const bool is_fourth = coupling.scheme == Scheme::fourth_order;
  const std::uint64_t pulses = is_fourth ? 6 : 1;
  // Each pulse sends velocities afterwards, and beforehand the numbers that each pass of the damping reads.
  const std::uint64_t passes = !is_damped(file.scene) ? 0 : is_fourth ? 2 : 1;
  return {.times = pulses * (1 + passes), .numbers = 3, .bytes = scalar_bytes};
}

}  // namespace

HaloMessages halo_of(const SceneFile& file, std::size_t scalar_bytes) {
  HaloMessages sent = halo_of_springs(file, scalar_bytes);
  sent.bytes = scalar_bytes;
  if (file.scene.meet) sent.numbers_to_all = 10;  // two positions, a velocity and a mass
  return sent;
}

std::vector<Cut> cuts_of(const Extent& extent, std::uint64_t ranks) {
  if (ranks > extent.particles) return {};
  if (!extent.is_joined()) return {cut_of_ranges(extent.particles, ranks)};
  std::vector<Cut> cuts;
  if (extent.sheet && extent.scene->coupling.scheme == Scheme::sequential) {
    return {cut_of_swept_sheet(*extent.sheet, ranks, rows_kept_together(*extent.scene, *extent.sheet),
                               rows_held(*extent.scene, *extent.sheet, 1))};
  }
  if (extent.sheet) {
    if (ranks <= extent.sheet->rows) {
      Cut& cut = cuts.emplace_back(cut_of_sheet(*extent.sheet, ranks, 1));
      cut.pulses = pulses_per_telling(*extent.scene, *extent.sheet, cut.fewest / extent.sheet->columns);
    }
    const auto blocks = best_blocks(*extent.sheet, ranks);
    if (blocks && (*blocks)[1] > 1) cuts.push_back(cut_of_sheet(*extent.sheet, (*blocks)[0], (*blocks)[1]));
    return cuts;
  }
  const auto springs = springs_of(*extent.list);
  cuts.push_back(cut_of_pairs(springs, stripes(*extent.list, extent.particles, static_cast<std::uint32_t>(ranks)), ranks));
  cuts.back().sharing = Sharing::stripes;
  if (const auto rows = swept_rows(*extent.list, extent.particles)) {
    // The halo of swept rows is deeper than springs reach.
    const Cut by_rows =
        cut_of_swept_sheet(*rows, ranks, rows_kept_together(*extent.list, *rows), rows_held(*extent.list, *rows, 1));
    cuts.back().halo = by_rows.halo;
    cuts.back().all_halo = by_rows.all_halo;
    cuts.back().neighbours = by_rows.neighbours;
    cuts.back().all_neighbours = by_rows.all_neighbours;
  }
  if (extent.list->coupling.scheme == Scheme::sequential) return cuts;
  if (const auto owner = owners_by_metis(springs, extent.particles, ranks)) {
    cuts.push_back(cut_of_pairs(springs, *owner, ranks));
    cuts.back().sharing = Sharing::metis;
  }
  return cuts;
}

namespace {

// Bytes of a sub-step. If several pulses are sent together, both positions and velocities are sent, of as many particles as the
// pulses would send one by one.
std::uint64_t bytes_of(std::uint64_t halo, const Cut& cut, const HaloMessages& sent) {
  return halo * sent.times * sent.numbers * sent.bytes * (cut.pulses > 1 ? 2 : 1);
}
double messages_of(std::uint64_t neighbours, const Cut& cut, const HaloMessages& sent) {
  const auto each = static_cast<double>(neighbours * sent.times);
  return cut.pulses > 1 ? 2 * each / static_cast<double>(cut.pulses) : each;
}

struct ToldInSubstep {
  std::uint64_t bytes = 0;
  double messages = 0;
};
ToldInSubstep told_to_one(const Cut& cut, const HaloMessages& sent) {
  const std::uint64_t to_all = sent.numbers_to_all * sent.bytes;
  return {.bytes = bytes_of(cut.halo, cut, sent) + (cut.all_particles - cut.fewest) * to_all,
          .messages = messages_of(cut.neighbours, cut, sent) + (to_all != 0 ? static_cast<double>(cut.ranks - 1) : 0)};
}
ToldInSubstep told_by_all(const Cut& cut, const HaloMessages& sent) {
  const std::uint64_t to_all = sent.numbers_to_all * sent.bytes;
  const std::uint64_t others = cut.ranks - 1;
  return {.bytes = bytes_of(cut.all_halo, cut, sent) + cut.all_particles * others * to_all,
          .messages = messages_of(cut.all_neighbours, cut, sent) + (to_all != 0 ? static_cast<double>(cut.ranks * others) : 0)};
}

}  // namespace

Times times_of(const Cut& cut, const HaloMessages& sent, const Machine& machine) {
  const auto [bytes, messages] = told_to_one(cut, sent);
  const std::uint64_t particles = sent.numbers_to_all != 0 ? cut.all_particles : cut.particles;
  return {.own = static_cast<double>(particles) * machine.particle_seconds.value(),
          .told = machine.latency * messages + static_cast<double>(bytes) / machine.bandwidth};
}

std::string table_of(const std::vector<Cut>& cuts, const HaloMessages& sent, const Machine& machine, const Cut& one) {
  std::string text = fmt::format("\nranks        {}\n", cuts.front().ranks);
  const double alone = times_of(one, sent, machine).all();
  for (const Cut& cut : cuts) {
    const Times times = times_of(cut, sent, machine);
    const auto row = [&](std::string_view name, const std::string& value) {
      text += fmt::format("  {:<22} {}\n", name, value);
    };
    text += fmt::format("shared by {}\n", name(cut.sharing));
    row("particles a rank",
        fmt::format("{} at most, {} at least; imbalance {:.4f}", cut.particles, cut.fewest, cut.imbalance()));
    if (cut.all_springs > 0) {
      row("springs a rank", fmt::format("{} at most", cut.springs));
      row("cut", fmt::format("{} of {} springs, {:.3g} %", cut.cut_springs, cut.all_springs,
                             100 * static_cast<double>(cut.cut_springs) / static_cast<double>(cut.all_springs)));
      row("halo a rank", fmt::format("{} particles at most, {} over all ranks", cut.halo, cut.all_halo));
    }
    if (cut.all_springs > 0 || sent.numbers_to_all != 0) {
      const ToldInSubstep to_one = told_to_one(cut, sent), all = told_by_all(cut, sent);
      row("told a sub-step", fmt::format("{} bytes in {:.15g} messages to a rank at most; {} bytes in {:.15g} over all ranks",
                                         to_one.bytes, to_one.messages, all.bytes, all.messages));
      if (sent.numbers_to_all != 0) row("", "of each particle where it has got: every rank works out all meetings");
      if (cut.pulses > 1) row("", fmt::format("{} sub-steps at a time, of a halo so many times as deep", cut.pulses));
    }
    row("predicted sub-step",
        fmt::format("{:.4g} s: {:.4g} s of particles, {:.4g} s of messages", times.all(), times.own, times.told));
    row("predicted efficiency", fmt::format("{:.3f}", alone / (static_cast<double>(cut.ranks) * times.all())));
  }
  return text;
}

std::vector<ScalePoint> curve_of(const Extent& extent, const HaloMessages& sent, const Machine& machine, std::uint64_t most) {
  std::vector<ScalePoint> curve;
  const double alone = least_time(extent, 1, sent, machine).value();
  // A list is not enlarged, so it has only the strong curve.
  for (std::uint64_t ranks = 1; ranks <= most; ranks *= 2) {
    const auto strong = least_time(extent, ranks, sent, machine);
    const auto weak = extent.list != nullptr ? std::nullopt : least_time(on_each(extent, ranks), ranks, sent, machine);
    if (!strong && !weak) break;
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    curve.push_back({.ranks = ranks,
                     .strong = strong ? alone / (static_cast<double>(ranks) * *strong) : none,
                     .weak = weak ? alone / *weak : none});
  }
  return curve;
}

std::string table_of(const std::vector<ScalePoint>& curve) {
  std::string text = fmt::format("\npredicted efficiency\n  {:>8}  {:>8}  {:>8}\n", "ranks", "strong", "weak");
  const auto shown = [](double efficiency) { return std::isnan(efficiency) ? "-" : fmt::format("{:.3f}", efficiency); };
  for (const auto& [ranks, strong, weak] : curve) {
    text += fmt::format("  {:>8}  {:>8}  {:>8}\n", ranks, shown(strong), shown(weak));
  }
  return text;
}

std::string picture_of(const std::vector<ScalePoint>& curve, const std::string& title) {
  std::string script = fmt::format(
      "set terminal svg size 640,400 dynamic background rgb 'white'\nset title {}\nset logscale x 10\nset format x "
      "'10^{{%T}}'\n"
      "set xlabel 'ranks'\nset ylabel 'predicted efficiency'\nset yrange [0:1.05]\nset grid\nset key bottom left\n$curve << "
      "EOD\n",
      gnuplot_literal(title));
  for (const auto& [ranks, strong, weak] : curve) script += fmt::format("{} {} {}\n", ranks, strong, weak);
  script +=
      "EOD\nplot $curve using 1:2 with linespoints title 'strong: this scene on all ranks', "
      "$curve using 1:3 with linespoints title 'weak: this scene on each rank'\n";
  auto drawn = run_gnuplot({script});
  if (!drawn) throw Fault(Exit::input_output, "the picture cannot be drawn: " + drawn.error());
  return std::move(drawn->front());
}

}  // namespace dvdx::tool
