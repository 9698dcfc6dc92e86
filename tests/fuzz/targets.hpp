// The fuzz targets. Each takes any bytes, and throws if the code under test breaks a promise. libFuzzer runs them (engine.cpp),
// and the ordinary tests run all of corpus/ through them (corpus_test.cpp).
#pragma once

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

namespace dvdx::fuzz {

// A broken promise.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};
inline void expect(bool holds, const std::string& promise) {
  if (!holds) throw Finding(promise);
}

void csv_reader(std::string_view bytes);
void npy_reader(std::string_view bytes);
void ply_reader(std::string_view bytes);
void obj_reader(std::string_view bytes);
void scene_reader(std::string_view bytes);
void overrides(std::string_view bytes);
void any_scene(std::string_view bytes);
void plan_step(std::string_view bytes);

struct Target {
  std::string_view name;
  void (*run)(std::string_view bytes);
};
inline constexpr std::array targets = {
    Target{"csv_reader", csv_reader},     Target{"npy_reader", npy_reader}, Target{"ply_reader", ply_reader},
    Target{"obj_reader", obj_reader},     Target{"overrides", overrides},   Target{"any_scene", any_scene},
    Target{"scene_reader", scene_reader}, Target{"plan_step", plan_step},
};

}  // namespace dvdx::fuzz
