#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "output/frame_coder.hpp"
#include "output/html_page.hpp"
#include "output/writer.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_file.hpp"
#include "support/close.hpp"
#include "tools/scratch_folder.hpp"

namespace html_writer_test {

using namespace dvdx;
using namespace dvdx::tool;
using dvdx::test::is_close;
using dvdx::test::ScratchFolder;

// A folder with a page that XML readers accept. DVDX_VIEWER names it during its lifetime.
class PageFolder : public ScratchFolder {
 public:
  explicit PageFolder(const std::string& name) : ScratchFolder("html-" + name) {
    write("playback.html", "<html><p>before</p><!-- dvdx data --><p>after</p></html>");
    setenv("DVDX_VIEWER", path().c_str(), 1);
  }
  ~PageFolder() { unsetenv("DVDX_VIEWER"); }
  PageFolder(const PageFolder&) = delete;
  PageFolder& operator=(const PageFolder&) = delete;
};

std::string unpacked(std::string_view text, std::size_t most) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<Bytef> bytes;
  std::uint32_t word = 0;
  unsigned bits = 0;
  for (const char c : text.substr(0, text.find('='))) {
    word = (word << 6U) | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) bytes.push_back(static_cast<Bytef>((word >> (bits -= 8)) & 0xFFU));
  }
  std::vector<Bytef> out(most);
  auto size = static_cast<uLongf>(most);
  REQUIRE(uncompress(out.data(), &size, bytes.data(), static_cast<uLong>(bytes.size())) == Z_OK);
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

// A frame as the page's reader decodes it.
struct Decoded {
  double time = 0;
  double spacing = 0;
  std::vector<float> x;  // x0 y0 z0 x1 ...
  std::vector<double> speed;
  std::vector<double> error;
  std::vector<std::size_t> was;  // the index of each particle in the previous frame, if it was there
};

// Written from the format's description in output/frame_coder.hpp, not from its code.
Decoded decoded(const pugi::xml_node& frame, const std::vector<Decoded>& earlier) {
  const auto count = frame.attribute("data-count").as_ullong();
  const auto planes = frame.attribute("data-planes").as_ullong();
  const int order = frame.attribute("data-order").as_int();
  const auto held = earlier.empty() ? 0 : earlier.back().x.size() / 3;
  const auto gone = frame.attribute("data-gone").as_ullong();
  const auto bytes = unpacked(frame.text().get(), (3 * planes + 2) * count + 1 + held);
  const auto marks = gone > 0 ? bytes.size() - (held + 7) / 8 : bytes.size();
  REQUIRE(bytes.size() >= (3 * planes + 1) * count);
  const auto byte = [&](std::size_t at) { return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at])); };
  Decoded result{.time = frame.attribute("data-time").as_double(),
                 .spacing = std::ldexp(1.0, frame.attribute("data-exponent").as_int()),
                 .x = std::vector<float>(3 * count),
                 .speed = {},
                 .error = {},
                 .was = {}};
  for (std::size_t k = 0; k < held; ++k) {
    if (gone == 0 || (byte(marks + k / 8) >> (k % 8) & 1) == 0) result.was.push_back(k);
  }
  REQUIRE(held - result.was.size() == gone);
  const auto past = [&](std::size_t back, std::size_t at, double otherwise) {
    std::size_t i = at / 3;
    const Decoded* frame_after = &result;
    for (std::size_t n = 1; n <= back; ++n) {
      if (i >= frame_after->was.size()) return otherwise;
      i = frame_after->was[i];
      frame_after = &earlier[earlier.size() - n];
    }
    return static_cast<double>(frame_after->x[3 * i + at % 3]);
  };
  double sum = 0;
  for (std::size_t k = 0; k < 3 * count; ++k) {
    std::uint64_t code = 0;
    for (std::size_t plane = 0; plane < planes; ++plane) code |= byte(plane * 3 * count + k) << (8 * plane);
    const double number = code % 2 == 0 ? static_cast<double>(code / 2) : -static_cast<double>((code + 1) / 2);
    sum = frame.attribute("data-across").as_int() == 1 ? sum + number : number;
    const auto at = 3 * (k % count) + k / count;
    const double last = past(1, at, 0);
    const double predicted = order == 0 ? 0.0 : order == 1 ? last : 2 * last - past(2, at, last);
    result.x[at] = static_cast<float>(predicted + sum * result.spacing);
  }
  for (std::size_t i = 0; i < count; ++i) {
    result.speed.push_back(frame.attribute("data-speed").as_double() * static_cast<double>(byte(3 * planes * count + i)) / 255);
  }
  for (std::size_t i = (3 * planes + 1) * count; i < marks; ++i) {
    const auto code = static_cast<double>(byte(i));
    result.error.push_back(code == 0 ? 0 : frame.attribute("data-error").as_double() * std::exp2((code - 255) / 8));
  }
  return result;
}

pugi::xml_document read_page(const ScratchFolder& folder, const char* name) {
  pugi::xml_document document;
  REQUIRE(document.load_string(folder.read(name).c_str()));
  return document;
}

std::vector<pugi::xml_node> elements(const pugi::xml_document& document, const std::string& name) {
  std::vector<pugi::xml_node> found;
  for (const auto& node : document.child("html").children("script")) {
    if (node.attribute("type").value() == "text/x-dvdx-" + name) found.push_back(node);
  }
  return found;
}

std::vector<Decoded> frames_of(const pugi::xml_document& document) {
  std::vector<Decoded> frames;
  for (const auto& node : elements(document, "frame")) frames.push_back(decoded(node, frames));
  return frames;
}

// Particles thrown up from different places. The later ones are absent at first.
template <class T>
class Fountain {
 public:
  explicit Fountain(std::size_t most) : memory_(most) {}
  State<T> at(std::size_t index, std::size_t count) {
    auto state = memory_.view();
    state.count = count;
    const double t = 0.05 * static_cast<double>(index);
    for (std::size_t i = 0; i < count; ++i) {
      const auto k = static_cast<double>(i);
      const std::array<double, 3> v{std::sin(k), 5 + std::cos(3 * k) - 9.81 * t, std::sin(7 * k)};
      const std::array<double, 3> x{v[0] * t + 0.01 * k, (5 + std::cos(3 * k)) * t - 4.905 * t * t, v[2] * t};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state.x[axis][i] = static_cast<T>(x[axis]);
        state.v[axis][i] = static_cast<T>(v[axis]);
      }
    }
    return state;
  }

 private:
  Soa<T> memory_;
};

template <class T>
void check_frame(const Decoded& frame, const State<T>& state) {
  REQUIRE(frame.x.size() == 3 * state.count);
  double speed_scale = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    speed_scale = std::max(speed_scale, std::hypot(double(state.v[0][i]), double(state.v[1][i]), double(state.v[2][i])));
  }
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double off = static_cast<double>(frame.x[3 * i + axis]) - static_cast<double>(state.x[axis][i]);
      CHECK(std::abs(off) <= 0.5001 * frame.spacing + 1e-6);
    }
    const double speed = std::hypot(double(state.v[0][i]), double(state.v[1][i]), double(state.v[2][i]));
    CHECK(std::abs(frame.speed[i] - speed) <= 0.51 * speed_scale / 255);
  }
}

TEST_CASE_TEMPLATE("an .html holds every state to half a lattice spacing, also as particles come", T, float, double) {
  const PageFolder folder("states");
  constexpr std::array<std::size_t, 6> counts{1100, 1100, 1200, 1200, 1200, 1500};
  Fountain<T> fountain(1500);
  const auto writer = make_writer<T>({.target = folder / "a.html", .particles = 1200, .states = counts.size()});
  for (std::size_t k = 0; k < counts.size(); ++k) {
    writer->write({.step = 3 * k, .time = 0.1 * static_cast<double>(k)}, fountain.at(k, counts[k]));
  }
  writer->finish();
  const auto document = read_page(folder, "a.html");
  const auto frames = frames_of(document);
  REQUIRE(frames.size() == counts.size());
  for (std::size_t k = 0; k < counts.size(); ++k) {
    CHECK(frames[k].time == 0.1 * static_cast<double>(k));
    CHECK(frames[k].spacing < 2e-3);  // relative to about 15 m
    check_frame(frames[k], fountain.at(k, counts[k]));
  }
  CHECK(elements(document, "frame")[5].attribute("data-step").as_int() == 15);
  CHECK(document.child("html").first_child().text().get() == std::string("before"));
  CHECK(document.child("html").last_child().text().get() == std::string("after"));
}

// Particle number n moves from its own place with its own velocity.
class Crowd {
 public:
  explicit Crowd(std::size_t most) : memory_(most) {}
  State<float> at(double t, const std::vector<std::uint32_t>& numbers) {
    auto state = memory_.view();
    state.count = numbers.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double n = numbers[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double v = std::sin(n * (2 + static_cast<double>(axis)));
        state.v[axis][i] = static_cast<float>(v);
        state.x[axis][i] = static_cast<float>(5 * std::cos(n * (3 + static_cast<double>(axis))) + v * t);
      }
    }
    return state;
  }

 private:
  Soa<float> memory_;
};

// The numbers from first to last, without the multiples of `every`.
std::vector<std::uint32_t> without(std::uint32_t first, std::uint32_t last, std::uint32_t every) {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t n = first; n <= last; ++n) {
    if (n % every != 0) numbers.push_back(n);
  }
  return numbers;
}

TEST_CASE("particles that come and go are followed from state to state, whatever the order they stand in") {
  for (const bool is_reversed : {false, true}) {
    const PageFolder folder(is_reversed ? "reversed" : "follow");
    const std::vector<std::vector<std::uint32_t>> moments{{},
                                                          without(1, 1500, 2000),
                                                          without(1, 1500, 2000),
                                                          without(3, 1700, 7),
                                                          without(3, 1700, 7),
                                                          without(3, 1700, 7),
                                                          without(1400, 1800, 7),
                                                          {},
                                                          {1900}};
    Crowd crowd(1700);
    std::vector<std::uint32_t> now;
    const auto writer = make_writer<float>({.target = folder / "a.html",
                                            .particles = 1700,
                                            .states = moments.size(),
                                            .counts = Counts::changing,
                                            .ids = [&](std::size_t) { return std::span<const std::uint32_t>(now); }});
    for (std::size_t k = 0; k < moments.size(); ++k) {
      now = moments[k];
      if (is_reversed) std::reverse(now.begin(), now.end());
      writer->write({.step = k, .time = 0.1 * static_cast<double>(k)}, crowd.at(0.1 * static_cast<double>(k), now));
    }
    writer->finish();
    const auto document = read_page(folder, "a.html");
    const auto frames = frames_of(document);
    REQUIRE(frames.size() == moments.size());
    for (std::size_t k = 0; k < moments.size(); ++k) {
      CAPTURE(k);
      check_frame(frames[k], crowd.at(0.1 * static_cast<double>(k), moments[k]));
      for (std::size_t i = 0; i < frames[k].was.size(); ++i) CHECK(moments[k][i] == moments[k - 1][frames[k].was[i]]);
    }
    const auto nodes = elements(document, "frame");
    CHECK(nodes[3].attribute("data-gone").as_int() == 2 + 214);
    CHECK(nodes[5].attribute("data-planes").as_int() == 1);  // two states predict the third
    CHECK(nodes[7].attribute("data-gone").as_int() == 343);
  }
}

TEST_CASE("a page of many particles that come and go shows the same particles for as long as they live") {
  const PageFolder folder("some");
  Crowd crowd(60'000);
  std::vector<std::uint32_t> now;
  const auto writer = make_writer<float>(
      {.target = folder / "a.html", .particles = 60'000, .states = 2, .counts = Counts::changing, .ids = [&](std::size_t) {
         return std::span<const std::uint32_t>(now);
       }});
  const auto shown = [&] {
    std::vector<std::uint32_t> even;
    for (const auto n : now) {
      if (n % 2 == 0) even.push_back(n);
    }
    return even;
  };
  now = without(1, 10'000, 20'000);
  const auto first = shown();
  writer->write({}, crowd.at(0, now));
  now = without(2, 12'000, 3);
  writer->write({.step = 1, .time = 1}, crowd.at(1, now));
  writer->finish();
  const auto document = read_page(folder, "a.html");
  const auto frames = frames_of(document);
  CHECK(elements(document, "frame")[1].attribute("data-all").as_ullong() == now.size());
  REQUIRE(frames[1].x.size() == 3 * shown().size());
  check_frame(frames[0], crowd.at(0, first));
  const auto second = shown();
  const auto wanted = crowd.at(1, second);
  for (std::size_t i = 0; i < second.size(); ++i) CHECK(std::abs(frames[1].x[3 * i] - wanted.x[0][i]) <= frames[1].spacing);
}

TEST_CASE("a page of few particles far from the origin keeps the accuracy of float32 there") {
  const PageFolder folder("far");
  Soa<float> memory(2);
  auto state = memory.view();
  const auto writer = make_writer<float>({.target = folder / "a.html", .particles = 2, .states = 40});
  std::vector<float> x;
  for (std::size_t k = 0; k < 40; ++k) {
    x.push_back(10000 + std::sin(0.1F * static_cast<float>(k)));
    state.x[0][1] = x.back();
    writer->write({.step = k, .time = 0}, state);
  }
  writer->finish();
  const auto frames = frames_of(read_page(folder, "a.html"));
  REQUIRE(frames.size() == 40);
  for (std::size_t k = 0; k < 40; ++k) CHECK(std::abs(frames[k].x[3] - x[k]) <= 2e-3);
}

TEST_CASE("a particle that is not finite stays where it was, and is counted") {
  const PageFolder folder("bad");
  Soa<float> memory(3);
  auto state = memory.view();
  const auto writer = make_writer<float>({.target = folder / "a.html", .particles = 3, .states = 2});
  state.x[1][2] = 4;
  writer->write({.step = 0, .time = 0}, state);
  state.x[1][1] = 2;
  state.x[1][2] = std::numeric_limits<float>::quiet_NaN();
  state.v[0][0] = std::numeric_limits<float>::infinity();
  writer->write({.step = 1, .time = 1}, state);
  writer->finish();
  const auto document = read_page(folder, "a.html");
  const auto frames = frames_of(document);
  CHECK(is_close(frames[1].x[4], 2, 1e-12));
  CHECK(is_close(frames[1].x[7], 4, 1e-12));
  CHECK(elements(document, "frame")[0].attribute("data-bad").as_int() == 0);
  CHECK(elements(document, "frame")[1].attribute("data-bad").as_int() == 1);
}

TEST_CASE("a page of many unjoined particles shows a part of them, and says so") {
  const PageFolder folder("many");
  Soa<float> memory(120001);
  auto state = memory.view();
  for (std::size_t i = 0; i < state.count; ++i) state.x[0][i] = static_cast<float>(i);
  const auto writer = make_writer<float>({.target = folder / "a.html", .particles = state.count, .states = 1});
  writer->write({}, state);
  writer->finish();
  const auto document = read_page(folder, "a.html");
  const auto scene = nlohmann::json::parse(elements(document, "scene")[0].text().get());
  CHECK(elements(document, "frame")[0].attribute("data-all").as_int() == 120001);
  CHECK(scene["every"] == 3);
  const auto frames = frames_of(document);
  REQUIRE(frames[0].x.size() == 3 * 40001);
  CHECK(is_close(frames[0].x[3 * 40000], 120000, 1e-4));
}

TEST_CASE("distances to a reference are held to an eighth of an octave") {
  const PageFolder folder("errors");
  Soa<float> memory(4);
  auto state = memory.view();
  for (std::size_t i = 0; i < 4; ++i) state.x[2][i] = static_cast<float>(std::pow(10.0, -2.0 * static_cast<double>(i)));
  const ReferencePositions zero = [](const Moment&, std::size_t) { return std::vector<double>(12); };
  const auto writer = make_writer<float>({.target = folder / "a.html", .particles = 4, .states = 1, .reference = zero});
  writer->write({}, state);
  writer->finish();
  const auto frames = frames_of(read_page(folder, "a.html"));
  REQUIRE(frames[0].error.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(is_close(frames[0].error[i], std::pow(10.0, -2.0 * static_cast<double>(i)), 0.05));
  }
}

TEST_CASE("a page holds the scene's data, whatever characters its name has") {
  const PageFolder folder("scene");
  SceneFile file{
      .path = "a.json", .name = "</script> & <b>", .about = "", .step = 0.1, .duration = 1, .particles = {}, .scene = {}};
  file.scene.add(Plane{.normal = {0, 2, 0}, .offset = -1});
  file.scene.add(Sphere{.radius = 2, .motion = 0});
  file.scene.add(Motion{.center = {1, 0, 0}, .keys = {{}, {.time = 2, .translation = {0, 3, 0}, .rotation = {0, 0, 1}}}});
  file.scene.fixed = {2};
  file.scene.kinematic = {{.particles = {0}}};
  file.scene.add(Spring{.stiffness = 1.0, .anchor = Vec3{1, 2, 3}});
  const Topology topology{.lines = {{2, 1}}, .faces = {{0, 1, 2}}};
  Soa<float> memory(3);
  const auto writer =
      make_writer<float>({.target = folder / "a.html", .particles = 3, .states = 1, .topology = &topology, .scene = &file});
  writer->write({}, memory.view());
  writer->finish();
  const auto document = read_page(folder, "a.html");
  const std::string text = elements(document, "scene")[0].text().get();
  CHECK(text.find('<') == std::string::npos);
  const auto scene = nlohmann::json::parse(text);
  CHECK(scene["name"] == "</script> & <b>");
  CHECK(scene["contacts"][0]["type"] == "plane");
  CHECK(scene["contacts"][0]["offset"] == -1);
  CHECK_FALSE(scene["contacts"][0].contains("motion"));
  CHECK(scene["contacts"][1]["motion"] == 0);
  CHECK(scene["motions"][0]["center"] == nlohmann::json{1, 0, 0});
  CHECK(scene["motions"][0]["keys"][1]["time"] == 2);
  CHECK(scene["motions"][0]["keys"][1]["translation"] == nlohmann::json{0, 3, 0});
  CHECK(scene["motions"][0]["keys"][1]["rotation"] == nlohmann::json{0, 0, 1});
  CHECK(scene["pins"] == nlohmann::json{2, 0});
  CHECK(scene["anchors"][0] == nlohmann::json{1, 2, 3});
  CHECK(unpacked(elements(document, "lines")[0].text().get(), 100).size() == 8);
  CHECK(unpacked(elements(document, "faces")[0].text().get(), 100) == std::string("\3\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0", 16));
}

TEST_CASE("a page holds which grids are nets, and the rest lengths of springs, rods and sides") {
  const PageFolder folder("rests");
  SceneFile file{.path = "a.json", .name = "", .about = "", .step = 0.1, .duration = 1, .particles = {}, .scene = {}};
  file.scene.add(Grid{.rows = 2, .columns = 3, .first = 1, .edge_u = {4, 0, 0}, .edge_v = {0, 0, 3}, .structural = 1});
  file.scene.add(Springs{.pairs = {{0, 1}, {7, 2}}, .stiffness = 1.0, .rest_length = Scalars(std::vector<double>{0.5, 0.25})});
  file.scene.add(Springs{.pairs = {{0, 3}}, .stiffness = 1.0});
  file.scene.add(Distance{.pairs = {{0, 4}}, .length = Scalars(0.125)});
  file.scene.add(Distance{.pairs = {{0, 5}}, .length = Scalars(2.0), .bound = Bound::at_most});
  const Topology topology{.lines = {{1, 0}, {2, 7}, {0, 3}, {4, 0}, {0, 5}}, .faces = {}, .nets = {{1, 6}}};
  const Output output{.target = folder / "a.html", .particles = 8, .states = 0, .topology = &topology, .scene = &file};
  make_writer<float>(output)->finish();
  const auto document = read_page(folder, "a.html");
  const auto scene = nlohmann::json::parse(elements(document, "scene")[0].text().get());
  CHECK(scene["nets"] == nlohmann::json{{1, 6}});
  REQUIRE(scene["sheets"].size() == 1);
  CHECK(scene["sheets"][0] == nlohmann::json{{"first", 1}, {"columns", 3}, {"count", 6}, {"sides", {2, 3}}});
  const auto bytes = unpacked(elements(document, "rests")[0].text().get(), 100);
  std::vector<float> rests(bytes.size() / sizeof(float));
  std::memcpy(rests.data(), bytes.data(), bytes.size());
  CHECK(rests == std::vector<float>{0.5F, 0.25F, 0, 0.125F, 0});
}

TEST_CASE("a frame's box leaves out a particle far away from all others, but not one only a little farther out") {
  const auto box_with = [](float last, std::size_t count) {
    std::array<std::vector<float>, 3> points{};
    for (auto& axis : points) axis.assign(count, 0.0F);
    for (std::size_t i = 0; i < count; ++i) points[1][i] = static_cast<float>(i % 9) - 4;
    points[0].back() = last;
    return box_of_nearly_all(points);
  };
  CHECK(box_with(1000, 500).high == std::array<double, 3>{0, 4, 0});
  CHECK(box_with(1000, 10).high[0] == 0);
  CHECK(box_with(1000, 9).high[0] == 1000);
  CHECK(box_with(8, 500).high[0] == 8);
  CHECK(box_with(-1000, 500).low == std::array<double, 3>{0, -4, 0});
  const PageFolder folder("box");
  Soa<float> memory(2);
  auto state = memory.view();
  state.x[0][1] = -0.5;
  state.x[2][0] = 3;
  const auto writer = make_writer<float>({.target = folder / "a.html", .particles = 2, .states = 2});
  writer->write({}, state);
  state.count = 0;
  writer->write({.step = 1, .time = 1}, state);
  writer->finish();
  const auto document = read_page(folder, "a.html");
  const auto frames = elements(document, "frame");
  CHECK(std::string(frames[0].attribute("data-box").value()) == "-0.5,0,0,0,0,3");
  CHECK(std::string(frames[1].attribute("data-box").value()).empty());
}

TEST_CASE("a page's gravity is the sum of all constant forces") {
  const PageFolder folder("gravity");
  SceneFile file{.path = "a.json", .name = "", .about = "", .step = 0.1, .duration = 1, .particles = {}, .scene = {}};
  file.scene.add(Constant{.acceleration = {1, -9, 0}}).add(Constant{.acceleration = {0.5, -1, 2}});
  make_writer<float>({.target = folder / "a.html", .particles = 3, .states = 0, .scene = &file})->finish();
  const auto document = read_page(folder, "a.html");
  CHECK(nlohmann::json::parse(elements(document, "scene")[0].text().get())["gravity"] == nlohmann::json{1.5, -10, 2});
}

TEST_CASE("without its page an .html is refused before anything is written, and the message says how to get it") {
  const PageFolder folder("missing");
  std::filesystem::remove(folder / "playback.html");
  try {
    const auto writer = make_writer<float>({.target = folder / "a.html", .particles = 1, .states = 1});
    FAIL("an .html without a page");
  } catch (const Fault& fault) {
    CHECK(fault.exit() == Exit::input_output);
    const std::string message = fault.what();
    CHECK(message.find(folder / "playback.html") != std::string::npos);
    CHECK(message.find("tools/run.sh demo") != std::string::npos);
  }
  CHECK(folder.entries() == 0);
  folder.write("playback.html", "<html></html>");
  CHECK_THROWS_AS(static_cast<void>(make_writer<float>({.target = folder / "a.html", .particles = 1, .states = 1})), Fault);
  CHECK(folder.entries() == 1);
}

TEST_CASE("an unfinished .html leaves no file") {
  const PageFolder folder("unfinished");
  {
    Soa<float> memory(1);
    const auto writer = make_writer<float>({.target = folder / "a.html", .particles = 1, .states = 2});
    writer->write({}, memory.view());
  }
  CHECK(folder.entries() == 1);
}

}  // namespace html_writer_test
