#include "watch/pinch_watch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <variant>

namespace dvdx::tool {
namespace {

double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Returns the contacts whose index has `bit` set or not, as asked for. They put particles out at once.
Scene group_of(const Scene& scene, unsigned bit, std::size_t is_set) {
  Scene group;
  group.motions = scene.motions;
  group.origin = scene.origin;
  for (std::size_t j = 0; j < scene.contacts.size(); ++j) {
    if ((j >> bit & 1) != is_set) continue;
    group.contacts.push_back(scene.contacts[j]);
    std::visit([](auto& contact) { contact.push_out.reset(); }, group.contacts.back());
  }
  return group;
}

}  // namespace

void PinchWatch::make_groups(std::size_t count) {
  are_free_ = free_ones(file_.scene, count);
  const auto bits = static_cast<unsigned>(std::bit_width(file_.scene.contacts.size() - 1));
  for (unsigned bit = 0; bit < bits; ++bit) {
    groups_.push_back({PushOutProbe(group_of(file_.scene, bit, 0), count), PushOutProbe(group_of(file_.scene, bit, 1), count)});
  }
}

template <class T>
void PinchWatch::look(const State<T>& state) {
  if (!looks_) return;
  if (groups_.empty()) make_groups(state.count);
  const double limit = least_depth(state);
  for (auto& [without, with] : groups_) {
    for (std::size_t first = 0; first < state.count; first += PushOutProbe::at_once) {
      const auto a = without.of(state, first);
      const auto b = with.of(state, first);
      for (std::size_t i = 0; i < a.size(); ++i) {
        if (!are_free_[first + i] || !(product(a[i], b[i]) < 0)) continue;
        const double of_a = std::sqrt(product(a[i], a[i])), of_b = std::sqrt(product(b[i], b[i]));
        const double depth = std::min(of_a, of_b);
        if (!(depth > limit) || (found_ && depth <= found_->depth)) continue;
        found_ = {.particle = first + i, .time = state.clock.seconds, .depth = depth, .overlap = of_a + of_b, .limit = limit};
      }
    }
  }
}

template void PinchWatch::look(const State<float>&);
template void PinchWatch::look(const State<double>&);

}  // namespace dvdx::tool
