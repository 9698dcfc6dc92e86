#include "springs/sweep/spring_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "topology/colouring.hpp"
#include "work/columns.hpp"

// A forward and a backward sweep leave a row of n stiff springs as soft as if each carried the force of about n of them. With
// k T >> 1, T the square of the time that sweeps look ahead by (springs/sweep/sweep_scheme.cpp), a load on the row sinks by
// g T times some power of n, whatever k is. A row that is solved at once holds its load. Springs j = 0..m-1 of a line join its
// particles p_0..p_m; u_j are their directions at the present shift, w_j is the inverse mass of p_j, k_j = kappa + eta,
// c_j = u_(j-1).u_j, and g_j - lambda_j the residual of spring j in a sweep's visit. The y_j that are added to lambda solve
//   (1/k_j + w_j + w_(j+1)) y_j - w_j c_j y_(j-1) - w_(j+1) c_(j+1) y_(j+1) = (g_j - lambda_j)/k_j
// and move each particle by  w_j (y_(j-1) u_(j-1) - y_j u_j): forces along springs, so that both momenta are kept as sweeps
// keep them. This is a block of a symmetric block Gauss-Seidel. With families of lines to and fro between the sweeps,
// S = -G x_f still has a symmetric G between 0 and 1, and the results of springs/sweep/sweep_scheme.cpp on linear springs hold.
//
// Elimination from one end, each row times k_j. The spring before leaves the share L of a particle's w, so that
//   left_j = L w_j,   p_j = 1/k_j + left_j + w_(j+1),   L_(j+1) = 1 - w_(j+1) c_(j+1)^2 / p_j
// No digit may be lost here: w may span many orders of magnitude, with a heavy load on light links. With
// s_j^2 = 1 - c_j^2 = |u_j - c_j u_(j-1)|^2, all terms are sums and products of numbers >= 0, each over P_j = k_j p_j:
//   E_j = 1 + k_j w_j L_j     P_j = E_j + k_j w_(j+1)     L_(j+1) = E_j / P_j + (k_j w_(j+1) / P_j) s_(j+1)^2
//   r_j = (g_j - lambda_j + k_j w_j c_j r_(j-1)) / P_j    y_j = r_j + (k_j w_(j+1) / P_j) c_(j+1) y_(j+1)
// P_j >= 1, so no pivot is needed, and float32 suffices. A spring without length, torn, or at a bad particle has u = 0 and
// k = 0: E = P = 1, L = 1, y = 0, and the line goes on behind it as if it began there. A fixed particle (w = 0) cuts it too.
//
// Tension turns springs. At fixed directions it would act on the bends that a line has before the sub-step, and move it by up
// to 4 gamma w times these, gamma_j = max(0, -lambda_j)/r_j: a rope of light links with a load on it would zigzag for ever,
// and hang 33 m too deep. So the motion of a spring's ends across it is eased by the stiffness of tension. It is solved along
// the line as y is, with the same elimination at c = 1. With q_j the impulses of a spring on its ends besides y_j u_j,
//   (1 + gamma_j (w_j + w_(j+1))) q_j - gamma_j w_j q_(j-1) - gamma_j w_(j+1) q_(j+1)
//     = gamma_j (w_j y_(j-1) (u_(j-1) - c_j u_j) + w_(j+1) y_(j+1) (u_(j+1) - c_(j+1) u_j))
// A spring's force then points along the turned spring. If gamma_j (w_j + w_(j+1)) is not above least_turning, gamma_j is
// taken as 0: springs that are stable at fixed directions cost nothing more.
//
// The force of a line's spring points along the spring at the time when the line is solved. Lines of other families then move
// its particles across it, by up to gamma w times as much as they are off: a sheet that falls into place from flat swings about
// its corners for ever. So if a sheet's springs turn far under their load, the force that lines gave a spring, y u + q in all
// of their solves, is kept as a vector f. The spring's backward visit redirects it: with u the direction then, f - (f.u) u is
// taken away, eased as one spring's turn is, by 1 / (1 + gamma (w_a + w_b)). To first order force and spring are parallel after
// the visit. A pressed spring's f is redirected too if it would turn the spring by less than half of its offset. Beyond that
// the spring buckles, and an f that follows it gives energy (8 of 224 random sheets gained up to two of their weight times
// their side; 0 of 372 without). Measured on sheets from flat: forces of the forward sweep need no redirection. Sheets keep
// swinging if f is redirected only where it is near the spring, or only under tension. They explode from sides of 48 on if f is
// taken back and the spring is solved anew.
//
// Sheets take the families V H D D' D H V: the second diagonals come once. All others take all of theirs to and fro, so that
// no line's bits depend on families that it does not touch.

namespace dvdx {
namespace {

constexpr std::uint32_t none = 0xffffffff;

}  // namespace

// ---- sheets -----------------------------------------------------------------------------------------------------------------

LineForces line_forces(double turning) noexcept {
  const bool turns_far = turning > most_turning_that_stays && turning <= most_turning_to_redirect;
  return turns_far ? LineForces::redirected : LineForces::stay;
}

// Each sheet may be stepped on a thread of its own.
LineRooms SheetLines::rooms() const noexcept {
  if (empty()) return {};
  return {.count = sheets, .each = LineRoom(terms()).numbers()};
}

std::size_t SheetLines::bytes() const noexcept { return bytes_of(families) + bytes_of(strands); }

SheetLines lines_of_sheets(const ParticleOrder& order, std::size_t rows, std::size_t columns, std::size_t sheet_rows,
                           std::span<const GridDirection> directions, std::span<const Strand> strands) {
  SheetLines lines;
  lines.rows = sheet_rows;
  lines.columns = columns;
  lines.sheets = rows / sheet_rows;
  lines.phases = order.phases;
  lines.pitch = order.pitch;
  const auto add = [&](std::size_t family) {
    const std::size_t first = lines.strands.size();
    lines.families.push_back({.down = static_cast<std::ptrdiff_t>(directions[family].down),
                              .right = directions[family].right,
                              .material = static_cast<std::uint32_t>(family),
                              .strands = static_cast<std::uint32_t>(first)});
    lines.strands.resize(first + rows * order.phases);
    for (const Strand& strand : strands) {
      if (strand.material != family) continue;
      lines.strands[first + strand.a / order.pitch] = {
          .first = static_cast<std::uint32_t>(strand.a % order.pitch), .count = strand.count, .springs = strand.springs};
    }
  };
  for (const auto& [down, right] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
    for (std::size_t f = 0; f < directions.size(); ++f) {
      if (directions[f].down == static_cast<std::size_t>(down) && directions[f].right == right) add(f);
    }
  }
  return lines;
}

// ---- lists ------------------------------------------------------------------------------------------------------------------

LineRooms ListLines::rooms(bool may_share_work) const noexcept {
  if (empty()) return {};
  std::size_t longest = 0;
  for (const LineBundle& bundle : bundles) longest = std::max<std::size_t>(longest, bundle.length);
  std::size_t most = 1;
  for (std::size_t family = 0; may_share_work && family + 1 < families.size(); ++family) {
    most = std::max(most, families[family + 1] - families[family]);
  }
  constexpr std::size_t most_tasks = 64;
  return {.count = std::min(most, most_tasks), .each = longest * line_room};
}

std::size_t ListLines::bytes() const noexcept { return bytes_of(bundles) + bytes_of(places) + bytes_of(families); }

namespace {

struct Line {
  std::vector<std::uint32_t> particles, springs;
};

// The spring that continues each spring at either end.
class Continuations {
 public:
  // is_swept: of each spring.
  Continuations(std::span<const JoinedPair> springs, std::span<const Vec3> start, const std::vector<bool>& is_swept)
      : springs_(springs), start_(start), at_(start.size()), next_(springs.size(), {none, none}) {
    for (std::uint32_t s = 0; s < springs.size(); ++s) {
      if (!is_swept[s]) continue;
      at_[springs[s].a].push_back(s);
      at_[springs[s].b].push_back(s);
    }
    for (std::uint32_t i = 0; i < at_.size(); ++i) pair_at(i, at_[i]);
  }
  [[nodiscard]] std::uint32_t next(std::uint32_t spring, std::uint32_t particle) const {
    return next_[spring][springs_[spring].a == particle ? 0 : 1];
  }
  [[nodiscard]] std::uint32_t other_end(std::uint32_t spring, std::uint32_t particle) const {
    return springs_[spring].a == particle ? springs_[spring].b : springs_[spring].a;
  }

 private:
  static constexpr double straight = -0.6;  // cosine between the directions that lead away
  static constexpr std::size_t most = 64;   // springs at a particle that are considered

  void join(std::uint32_t particle, std::uint32_t s, std::uint32_t t) {
    next_[s][springs_[s].a == particle ? 0 : 1] = t;
    next_[t][springs_[t].a == particle ? 0 : 1] = s;
  }
  // A particle with two springs belongs to a rope, whichever way it is laid out.
  void pair_at(std::uint32_t i, std::span<const std::uint32_t> at) {
    if (at.size() == 2 && other_end(at[0], i) != other_end(at[1], i)) return join(i, at[0], at[1]);
    if (at.size() > most) at = at.first(most);
    std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;
    for (std::size_t m = 0; m < at.size(); ++m) {
      for (std::size_t n = m + 1; n < at.size(); ++n) {
        const std::optional<double> cosine = cosine_at(i, at[m], at[n]);
        if (cosine && *cosine < straight) pairs.emplace_back(*cosine, at[m], at[n]);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<std::uint32_t> taken;
    const auto is_taken = [&](std::uint32_t s) { return std::find(taken.begin(), taken.end(), s) != taken.end(); };
    for (const auto& [cosine, s, t] : pairs) {
      if (is_taken(s) || is_taken(t)) continue;
      taken.insert(taken.end(), {s, t});
      join(i, s, t);
    }
  }
  [[nodiscard]] std::optional<double> cosine_at(std::uint32_t i, std::uint32_t s, std::uint32_t t) const {
    const auto away = [&](std::uint32_t spring) {
      const Vec3& to = start_[other_end(spring, i)];
      return Vec3{to[0] - start_[i][0], to[1] - start_[i][1], to[2] - start_[i][2]};
    };
    const Vec3 d = away(s);
    const Vec3 e = away(t);
    const auto dot = [](const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    const double square = dot(d, d) * dot(e, e);
    if (!(square > 0) || !std::isfinite(square)) return cosine_at_rest(i, s, t);
    return dot(d, e) / std::sqrt(square);
  }
  // Returns the cosine by the rest lengths of the triangle that a third spring closes.
  [[nodiscard]] std::optional<double> cosine_at_rest(std::uint32_t i, std::uint32_t s, std::uint32_t t) const {
    const std::uint32_t from = other_end(s, i);
    const std::uint32_t to = other_end(t, i);
    for (const std::uint32_t third : at_[from]) {
      if (other_end(third, from) != to) continue;
      const double d = springs_[s].l, e = springs_[t].l, f = springs_[third].l;
      if (d * e > 0) return (d * d + e * e - f * f) / (2 * d * e);
    }
    return std::nullopt;
  }

  std::span<const JoinedPair> springs_;
  std::span<const Vec3> start_;
  std::vector<std::vector<std::uint32_t>> at_;  // of each particle, its springs
  std::vector<std::array<std::uint32_t, 2>> next_;
};

// Walks from spring to spring, and cuts a line where it returns to one of its own particles.
class LineWalk {
 public:
  LineWalk(std::span<const JoinedPair> springs, const Continuations& by, std::size_t particles)
      : springs_(springs), by_(by), is_done_(springs.size(), false), line_of_(particles, none) {}

  void walk(const std::vector<bool>& is_swept) {
    for (const bool closed : {false, true}) {
      for (std::uint32_t s = 0; s < springs_.size(); ++s) {
        if (!is_swept[s] || is_done_[s]) continue;
        const bool ends_at_a = by_.next(s, springs_[s].a) == none;
        if (!closed && !ends_at_a && by_.next(s, springs_[s].b) != none) continue;
        walk_from(s, ends_at_a || closed ? springs_[s].a : springs_[s].b);
      }
    }
  }
  // A single spring is no line: a visit solves it just as well.
  [[nodiscard]] std::vector<Line> lines() && {
    std::erase_if(lines_, [](const Line& line) { return line.springs.size() < 2; });
    return std::move(lines_);
  }

 private:
  void walk_from(std::uint32_t s, std::uint32_t particle) {
    begin_at(particle);
    for (; s != none && !is_done_[s]; s = by_.next(s, particle)) {
      const std::uint32_t to = by_.other_end(s, particle);
      if (line_of_[to] == number()) begin_at(particle);
      is_done_[s] = true;
      lines_.back().springs.push_back(s);
      take(to);
      particle = to;
    }
  }
  void begin_at(std::uint32_t particle) {
    lines_.emplace_back();
    take(particle);
  }
  void take(std::uint32_t particle) {
    lines_.back().particles.push_back(particle);
    line_of_[particle] = number();
  }
  [[nodiscard]] std::uint32_t number() const { return static_cast<std::uint32_t>(lines_.size()); }

  std::span<const JoinedPair> springs_;
  const Continuations& by_;
  std::vector<bool> is_done_;
  std::vector<std::uint32_t> line_of_;  // the last line that took each particle
  std::vector<Line> lines_;
};

// Up to 16 lines, the longest first.
void add_bundle(std::span<const Line* const> lines, const ParticleOrder& order, std::span<const std::uint32_t> lane_of,
                ListLines& to) {
  const auto next_place = [&] { return static_cast<std::uint32_t>(to.places.size()); };
  const std::size_t length = lines[0]->springs.size();
  const auto line = [&](std::size_t lane) -> const Line& { return *lines[std::min(lane, lines.size() - 1)]; };
  LineBundle bundle{.lanes = static_cast<std::uint32_t>(lines.size()),
                    .length = static_cast<std::uint32_t>(length),
                    .particles = next_place()};
  for (std::size_t j = 0; j <= length; ++j) {
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const auto& particles = line(lane).particles;
      to.places.push_back(order.of[particles[std::min(j, particles.size() - 1)]]);
    }
  }
  bundle.springs = next_place();
  for (std::size_t j = 0; j < length; ++j) {
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const auto& springs = line(lane).springs;
      to.places.push_back(lane_of[springs[std::min(j, springs.size() - 1)]]);
    }
  }
  bundle.lengths = next_place();
  for (std::size_t lane = 0; lane < slice; ++lane) {
    to.places.push_back(static_cast<std::uint32_t>(line(lane).springs.size()));
  }
  to.bundles.push_back(bundle);
}

}  // namespace

ListLines lines_of_list(std::span<const JoinedPair> springs, std::span<const Vec3> start, const ParticleOrder& order,
                        std::span<const std::uint32_t> spring_at) {
  std::vector<bool> is_swept(springs.size(), false);
  std::vector<std::uint32_t> lane_of(springs.size(), none);
  for (std::uint32_t lane = 0; lane < spring_at.size(); ++lane) {
    if (spring_at[lane] >= springs.size()) continue;  // no spring
    is_swept[spring_at[lane]] = true;
    lane_of[spring_at[lane]] = lane;
  }
  const Continuations continuations(springs, start, is_swept);
  LineWalk walk(springs, continuations, start.size());
  walk.walk(is_swept);
  std::vector<Line> lines = std::move(walk).lines();
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.springs.size() > b.springs.size(); });

  std::vector<std::vector<const Line*>> families;
  Colouring colouring(start.size());
  for (const Line& line : lines) {
    const std::size_t family = colouring.add(line.particles);
    if (families.size() <= family) families.resize(family + 1);
    families[family].push_back(&line);
  }
  ListLines found;
  for (const std::vector<const Line*>& family : families) {
    found.families.push_back(found.bundles.size());
    for (std::size_t n = 0; n < family.size(); n += slice) {
      add_bundle(std::span(family).subspan(n, std::min(slice, family.size() - n)), order, lane_of, found);
    }
  }
  found.families.push_back(found.bundles.size());
  return found;
}

}  // namespace dvdx
