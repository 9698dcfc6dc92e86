#include "free/rate_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "forces/paired.hpp"
#include "forces/shear.hpp"
#include "forces/spring.hpp"
#include "math/elementary.hpp"
#include "math/psi.hpp"

namespace dvdx {
namespace {

constexpr std::size_t chunk_size = 256;  // particles whose coefficients are made together: twelve columns of 2 KiB
using Numbers = std::array<double, chunk_size>;

// For the particles of a Range: the rates of one group of their forces, and the coefficients of its step.
struct Group {
  Numbers W, g;
  Numbers A, B, C, S, X;
};

struct Range {
  std::size_t axis, first, n;
};

template <class T>
class Maker {
 public:
  Maker(const System& system, const FreeKernels<T>& passes, std::span<const std::size_t> column_sources, const Rates<T>& rates)
      : system_(system), passes_(passes), column_sources_(column_sources), rates_(rates), h_(system.flow_step()) {}

  void make(Flow flow, const Range& range) {
    fill([&](std::size_t i) { return system_.combined_rate(range.axis, i); }, range);
    run(range);
    if (flow == Flow::rate_shear) {
      write_shear(range);
    } else {
      sum_ = group_;
    }
    write_combined_gains(range);
    for (const std::size_t force : system_.separate()) add(force, range);
    if (flow != Flow::rate_shear) write_sum(flow, range);
  }

 private:
  template <class RateOf>
  void fill(const RateOf& rate_of, const Range& range) {
    group_.W.fill(0);
    group_.g.fill(0);
    for (std::size_t j = 0; j < range.n; ++j) {
      const Rate rate = rate_of(range.first + j);
      group_.W[j] = rate.W;
      group_.g[j] = rate.g;
    }
  }

  void run(const Range& range) {
    passes_.rate({.count = chunk_size,
                  .h = h_,
                  .W = group_.W.data(),
                  .g = group_.g.data(),
                  .A = group_.A.data(),
                  .B = group_.B.data(),
                  .C = group_.C.data(),
                  .S = group_.S.data(),
                  .X = group_.X.data()});
    // Beyond the lanes' range of angles combined() makes the coefficients instead.
    for (std::size_t j = 0; j < range.n; ++j) {
      if (std::sqrt(group_.W[j]) * std::abs(h_) <= sincos_fast) continue;
      const Combined k = combined(group_.W[j], group_.g[j], h_);
      group_.A[j] = k.A;
      group_.B[j] = k.B;
      group_.C[j] = k.C;
      group_.S[j] = k.S;
      group_.X[j] = k.constant.x;
    }
  }

  static void put(const T* column, std::size_t i, double value) { const_cast<T*>(column)[i] = static_cast<T>(value); }

  void put_gain(std::size_t k, const Range& range, std::size_t j, const Gain& gain) {
    put(rates_.gain_v[k][range.axis], range.first + j, gain.v);
    put(rates_.gain_x[k][range.axis], range.first + j, gain.x);
  }

  void write_shear(const Range& range) {
    for (std::size_t j = 0; j < range.n; ++j) {
      const Combined exact{
          .A = group_.A[j], .B = group_.B[j], .C = group_.C[j], .D = h_ - group_.S[j], .S = group_.S[j], .constant = {}};
      const ShearF k = paired(shear(exact, 0, h_));
      put(rates_.sign[range.axis], range.first + j, k.sign);
      put(rates_.t1[range.axis], range.first + j, k.t1);
      put(rates_.s[range.axis], range.first + j, k.s);
      put(rates_.t2[range.axis], range.first + j, k.t2);
    }
  }

  void write_sum(Flow flow, const Range& range) {
    for (std::size_t j = 0; j < range.n; ++j) {
      put(rates_.B[range.axis], range.first + j, sum_.B[j]);
      put(rates_.S[range.axis], range.first + j, sum_.S[j]);
      if (flow != Flow::rate_fused) continue;
      put(rates_.A[range.axis], range.first + j, sum_.A[j]);
      put(rates_.C[range.axis], range.first + j, sum_.C[j]);
    }
  }

  void write_combined_gains(const Range& range) {
    for (std::size_t k = 0; k < column_sources_.size(); ++k) {
      const Source& source = system_.sources()[column_sources_[k]];
      if (source.group != Source::Group::combined) continue;
      if (source.kind == Source::Kind::sine) {
        write_sinusoid(k, source, range);  // and its cosine, which follows
        continue;
      }
      for (std::size_t j = 0; j < range.n; ++j) {
        switch (source.kind) {
          case Source::Kind::constant:
            put_gain(k, range, j, {.v = group_.S[j], .x = group_.X[j]});
            break;
          case Source::Kind::wind: {
            const double g = system_.rate(source.force, range.axis, range.first + j).g;
            put_gain(k, range, j, {.v = g * group_.S[j], .x = g * group_.X[j]});
            break;
          }
          case Source::Kind::monomial:
            put_gain(k, range, j, combined_monomial(source.power, group_.W[j], group_.g[j], h_));
            break;
          case Source::Kind::sine:
          case Source::Kind::cosine:   // written with its sine
          case Source::Kind::anchors:  // of springs that stand alone
            break;
        }
      }
    }
  }

  void write_sinusoid(std::size_t k, const Source& source, const Range& range) {
    const double angular_frequency = system_.angular_frequency(source.force);
    Numbers in_v, in_x, quad_v, quad_x;
    passes_.rate_sinusoid({.count = chunk_size,
                           .h = h_,
                           .theta = angular_frequency * h_,
                           .W = group_.W.data(),
                           .g = group_.g.data(),
                           .in_v = in_v.data(),
                           .in_x = in_x.data(),
                           .quad_v = quad_v.data(),
                           .quad_x = quad_x.data()});
    const bool is_slow = std::abs(angular_frequency * h_) <= psi_taylor_limit;
    for (std::size_t j = 0; j < range.n; ++j) {
      SinusoidGains gains{{.v = in_v[j], .x = in_x[j]}, {.v = quad_v[j], .x = quad_x[j]}};
      const bool is_tiny = (group_.W[j] * h_) * h_ <= psi_taylor_limit && std::abs(group_.g[j] * h_) <= psi_taylor_limit;
      if (!is_slow || !is_tiny) gains = combined_sinusoid(group_.W[j], group_.g[j], angular_frequency, h_);
      put_gain(k, range, j, gains.in_phase);
      put_gain(k + 1, range, j, gains.quadrature);
    }
  }

  // Adds one spring or drag that stands alone.
  void add(std::size_t force, const Range& range) {
    fill([&](std::size_t i) { return system_.rate(force, range.axis, i); }, range);
    if (system_.is_truncated(force)) {
      for (std::size_t j = 0; j < range.n; ++j)
        add_one(force, range, j, system_.contribution(force, range.axis, range.first + j));
      return;
    }
    run(range);
    for (std::size_t j = 0; j < range.n; ++j) {
      const Combined k{.A = group_.A[j],
                       .B = group_.B[j],
                       .C = group_.C[j],
                       .D = h_ - group_.S[j],
                       .S = group_.S[j],
                       .constant = {.v = group_.S[j], .x = group_.X[j]}};
      add_one(force, range, j, by_method(k, group_.W[j], group_.g[j], h_, system_.method(force)));
    }
  }

  void add_one(std::size_t force, const Range& range, std::size_t j, const Contribution& more) {
    sum_.A[j] += more.A;
    sum_.B[j] += more.B;
    sum_.C[j] += more.C;
    sum_.S[j] -= more.D;
    for (std::size_t k = 0; k < column_sources_.size(); ++k) {
      const Source& source = system_.sources()[column_sources_[k]];
      if (source.group != Source::Group::alone) continue;
      if (source.kind == Source::Kind::wind && source.force == force) put_gain(k, range, j, {.v = more.B, .x = more.D});
      if (source.kind == Source::Kind::anchors) add_anchor(k, force, range, j, more);
    }
  }

  void add_anchor(std::size_t k, std::size_t force, const Range& range, std::size_t j, const Contribution& more) {
    const bool is_first = force == system_.separate().front();
    const double away = system_.anchor_distance(force, range.axis, range.first + j);
    anchors_v_[j] = (is_first ? 0 : anchors_v_[j]) + more.A * away;
    anchors_x_[j] = (is_first ? 0 : anchors_x_[j]) + more.C * away;
    put_gain(k, range, j, {.v = anchors_v_[j], .x = anchors_x_[j]});
  }

  const System& system_;
  const FreeKernels<T>& passes_;
  std::span<const std::size_t> column_sources_;
  const Rates<T>& rates_;
  double h_;
  Group group_, sum_;
  Numbers anchors_v_, anchors_x_;
};

}  // namespace

template <class T>
void make_rates(const System& system, const FreeKernels<T>& passes, Flow flow, std::size_t count,
                std::span<const std::size_t> column_sources, const Rates<T>& rates) {
  const auto is_anchors = [&](std::size_t k) { return system.sources()[k].kind == Source::Kind::anchors; };
  const bool has_anchors = std::any_of(column_sources.begin(), column_sources.end(), is_anchors);
  // The axes share isotropic columns, except those of the anchors.
  const std::size_t axes = system.is_isotropic() && !has_anchors ? 1 : 3;
  Maker<T> maker(system, passes, column_sources, rates);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    for (std::size_t first = 0; first < count; first += chunk_size) {
      maker.make(flow, {.axis = axis, .first = first, .n = std::min(chunk_size, count - first)});
    }
  }
}

template void make_rates<float>(const System&, const FreeKernels<float>&, Flow, std::size_t, std::span<const std::size_t>,
                                const Rates<float>&);
template void make_rates<double>(const System&, const FreeKernels<double>&, Flow, std::size_t, std::span<const std::size_t>,
                                 const Rates<double>&);

}  // namespace dvdx
