// Leapfrog over plain arrays that the compiler vectorises. Its figures scale those of two machines.
#include <algorithm>

#include "peers/peer.hpp"
#include "peers/plain_sheet.hpp"

namespace dvdx::bench {
namespace {

template <class T>
struct Arrays {
  PlainSheet<T> sheet;
  std::vector<T> x, v, a;

  explicit Arrays(const Cloth& cloth) : sheet(cloth), a(cloth.start.x.size()) {
    for (const double value : cloth.start.x) x.push_back(static_cast<T>(value));
    for (const double value : cloth.start.v) v.push_back(static_cast<T>(value));
  }

  static void move(T* __restrict to, const T* __restrict rate, T h, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) to[i] += h * rate[i];
  }
  static void kick_and_drift(T* __restrict at, T* __restrict speed, const T* __restrict rate, T kick, T drift,
                             std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      speed[i] += kick * rate[i];
      at[i] += drift * speed[i];
    }
  }
  void step_frame(int substeps) {
    const T h = static_cast<T>(frame_time / substeps);
    move(x.data(), v.data(), h / 2, x.size());
    for (int i = 1; i <= substeps; ++i) {
      sheet.accelerate(x.data(), a.data());
      kick_and_drift(x.data(), v.data(), a.data(), h, i < substeps ? h : h / 2, x.size());
    }
  }
};

template <class T>
tl::expected<Outcome, std::string> run(const Cloth& cloth, int substeps, double seconds) {
  Arrays<T> arrays(cloth);
  const double taken = time_once([&] {
    for (std::size_t i = 0; i < steps_of(seconds, 1); ++i) arrays.step_frame(substeps);
  });
  return Outcome{{{arrays.x.begin(), arrays.x.end()}, {arrays.v.begin(), arrays.v.end()}}, taken};
}

}  // namespace

Peers plain_leapfrog_arrays_peers() {
  return {{"leapfrog, plain arrays, autovectorised, f32", "sub-steps", leapfrog_ladder, run<float>},
          {"leapfrog, plain arrays, autovectorised, f64", "sub-steps", leapfrog_ladder, run<double>}};
}

}  // namespace dvdx::bench
