// Sheets that fall, are dragged and are thrown: the start of each run of an ensemble.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "scene_io/scene_file.hpp"
#include "state/engine.hpp"

namespace dvdx::tool::stability {

enum class Form { grid, mesh };
enum class Hold { corners, edge, nothing };
enum class Obstacle { none, floor, sphere };
enum class Pins { rest, jump, there_and_back, teleport, round };
enum class FrameTimes { even, mild, wide, in_turn, hitches };
inline constexpr std::array<Named<Form>, 2> forms{{{"grid", Form::grid}, {"mesh", Form::mesh}}};
inline constexpr std::array<Named<Hold>, 3> holds{
    {{"corners", Hold::corners}, {"edge", Hold::edge}, {"nothing", Hold::nothing}}};
inline constexpr std::array<Named<Obstacle>, 3> obstacles{
    {{"none", Obstacle::none}, {"floor", Obstacle::floor}, {"sphere", Obstacle::sphere}}};
inline constexpr std::array<Named<Pins>, 5> pin_drives{{{"at rest", Pins::rest},
                                                        {"jump by 0.3 m", Pins::jump},
                                                        {"go 2 m at 20 m/s and back", Pins::there_and_back},
                                                        {"jump by 2 m", Pins::teleport},
                                                        {"go round at 3 m/s for 1 s", Pins::round}}};
inline constexpr std::array<Named<FrameTimes>, 5> frame_times{{{"even", FrameTimes::even},
                                                               {"8 to 33 ms", FrameTimes::mild},
                                                               {"3 to 50 ms", FrameTimes::wide},
                                                               {"33, 17, 17 ms", FrameTimes::in_turn},
                                                               {"250 ms now and then", FrameTimes::hitches}}};

// A sheet of 2 m x 2 m and 1 kg, level at the start, under 9.81 m/s^2, in a plan for 60 steps a second. With driven pins it
// measures 1 m x 1 m and hangs.
struct Setting {
  std::string_view group{};  // "kicked": the group's name
  Form form = Form::grid;
  std::size_t side = 32;   // particles
  double stiffness = 1e4;  // N/m, of every spring
  double damping = 0;      // kg/s, of every spring
  int substeps = 1;
  Hold hold = Hold::corners;
  Obstacle obstacle = Obstacle::none;
  double restitution = 0;
  double kick = 0;  // m/s, initial velocity of all particles that are not held
  double pull = 0;  // m: amplitude of the held particles, which oscillate with period pull_seconds
  double pull_seconds = 1;
  FrameTimes times = FrameTimes::even;
  Pins pins = Pins::rest;  // after 1 s; a jump takes a frame
  Precision precision = Precision::float32;
  std::uint64_t seed = 0;  // seed of directions, of a mesh's shape, and of velocities of 1e-6 m/s
  std::uint64_t frames = 300;

  [[nodiscard]] bool drives_pins() const noexcept { return pins != Pins::rest; }
};

inline constexpr double frames_a_second = 60;

enum class Ensemble {
  whole,
  coarse,  // a few runs of each group; all together take seconds
};
[[nodiscard]] std::vector<Setting> settings_of(Ensemble ensemble);

// s
[[nodiscard]] double frame_time(const Setting& setting, std::uint64_t frame);

// Returns the scene of a setting with this coupling and the setting's sub-steps. Held particles that oscillate rest in the
// scene's coordinates, which move with them. Everything else then feels the opposite acceleration, and nothing else changes.
[[nodiscard]] SceneFile scene_of(const Setting& setting, Coupling coupling);

}  // namespace dvdx::tool::stability
