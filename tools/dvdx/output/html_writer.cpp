// A page that plays the states: the viewer's own page with the scene, its joints and a frame a state in script elements.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "output/base64.hpp"
#include "output/bytes.hpp"
#include "output/deflate.hpp"
#include "output/frame_coder.hpp"
#include "output/html_page.hpp"
#include "output/part_file.hpp"
#include "output/writer.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/names.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_shown = 50000;    // of particles that nothing joins
constexpr std::size_t most_anchored = 2000;  // springs to anchors that are drawn

// Joined particles are all needed for their lines and faces.
std::size_t stride_of(const Output& output) {
  if (*output.topology != no_topology) return 1;
  return std::max<std::size_t>(1, (output.particles + most_shown - 1) / most_shown);
}

Json json_of(const Contact& contact) {
  if (const auto* plane = std::get_if<Plane>(&contact)) {
    return {{"type", "plane"}, {"normal", plane->normal}, {"offset", plane->offset}};
  }
  const auto& sphere = std::get<Sphere>(contact);
  return {{"type", "sphere"},
          {"center", sphere.center},
          {"radius", sphere.radius},
          {"side", sphere.side == Side::inside ? "inside" : "outside"}};
}

std::optional<Anchor> anchor_of(const Force& force) {
  if (const auto* spring = std::get_if<Spring>(&force)) return spring->anchor;
  if (const auto* spring = std::get_if<RadialSpring>(&force)) return spring->anchor;
  return std::nullopt;
}

// One spring's anchors: a point for all particles, one each, or "start".
Json json_of(const Anchor& anchor) {
  if (const auto* point = std::get_if<Vec3>(&anchor)) return *point;
  if (const auto* points = std::get_if<std::vector<Vec3>>(&anchor)) return *points;
  return "start";
}

Vec3 gravity_of(const Scene& scene) {
  Vec3 gravity{};
  for (const auto& force : scene.forces) {
    const auto* constant = std::get_if<Constant>(&force);
    for (std::size_t axis = 0; constant != nullptr && axis < 3; ++axis) gravity[axis] += constant->acceleration[axis];
  }
  return gravity;
}

Json json_of(const Output& output) {
  Json json{{"every", stride_of(output)}, {"states", output.states}};
  if (output.scene == nullptr) return json;
  const auto& file = *output.scene;
  json["name"] = file.name;
  json["about"] = file.about;
  json["method"] = name_in(methods, file.scene.method);
  json["gravity"] = gravity_of(file.scene);
  json["step"] = file.step;
  json["duration"] = file.duration;
  json["reference"] = output.reference_text;
  json["contacts"] = Json::array();
  for (const auto& contact : file.scene.contacts) json["contacts"].push_back(json_of(contact));
  json["anchors"] = Json::array();
  if (output.counts == Counts::fixed && output.particles <= most_anchored) {
    for (const auto& force : file.scene.forces) {
      if (const auto anchor = anchor_of(force)) json["anchors"].push_back(json_of(*anchor));
    }
  }
  return json;
}

std::string packed(const std::vector<std::uint32_t>& numbers) { return base64(deflated(bytes_of(numbers))); }

// The two ends of each line.
std::string lines_element(const Topology& topology) {
  std::vector<std::uint32_t> ends;
  for (const auto& line : topology.lines) ends.insert(ends.end(), line.begin(), line.end());
  return fmt::format("<script type=\"text/x-dvdx-lines\">{}</script>\n", packed(ends));
}

// Of each face the number of its corners, then the corners.
std::string faces_element(const Topology& topology) {
  std::vector<std::uint32_t> corners;
  for (const auto& face : topology.faces) {
    corners.push_back(static_cast<std::uint32_t>(face.size()));
    corners.insert(corners.end(), face.begin(), face.end());
  }
  return fmt::format("<script type=\"text/x-dvdx-faces\">{}</script>\n", packed(corners));
}

std::string bounds_element(const Bounds& bounds) {
  return json_element("bounds", {{"low", bounds.low}, {"high", bounds.high}, {"speed", bounds.speed}, {"error", bounds.error}});
}

std::string frame_element(const Moment& moment, const Frame& frame) {
  return fmt::format(
      "<script type=\"text/x-dvdx-frame\" data-step=\"{}\" data-time=\"{}\" data-all=\"{}\" data-count=\"{}\" "
      "data-gone=\"{}\" data-bad=\"{}\" "
      "data-exponent=\"{}\" data-order=\"{}\" data-across=\"{}\" data-planes=\"{}\" data-speed=\"{}\" data-error=\"{}\">{}"
      "</script>\n",
      moment.step, moment.time, frame.all, frame.count, frame.gone, frame.bad, frame.exponent, frame.order,
      frame.difference == Difference::across ? 1 : 0, frame.planes, frame.speed, frame.error, base64(frame.bytes));
}

template <class T>
class HtmlWriter final : public Writer<T> {
 public:
  HtmlWriter(const Output& output, HtmlPage page)
      : after_(std::move(page.after)),
        reference_(output.reference),
        ids_(output.ids),
        stride_(stride_of(output)),
        coder_(stride_),
        file_(output.target) {
    file_.write(page.before);
    file_.write(json_element("scene", json_of(output)));
    file_.write(lines_element(*output.topology));
    file_.write(faces_element(*output.topology));
  }

  void write(const Moment& moment, const State<T>& state) override {
    const auto reference = reference_ ? reference_(moment, stride_) : std::vector<double>();
    const auto ids = ids_ ? ids_(state.count) : std::span<const std::uint32_t>();
    file_.write(frame_element(moment, coder_.code(state, reference, ids)));
  }

  void finish() override {
    file_.write(bounds_element(coder_.bounds()));
    file_.write(after_);
    file_.commit();
  }

 private:
  std::string after_;
  ReferencePositions reference_;
  ParticleIds ids_;
  std::size_t stride_;
  FrameCoder<T> coder_;
  PartFile file_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_html_writer(const Output& output) {
  auto page = find_page("playback");
  if (!page) throw Fault(Exit::input_output, fmt::format("{}: cannot be written: {}", output.target.string(), page.error()));
  return std::make_unique<HtmlWriter<T>>(output, *std::move(page));
}

template std::unique_ptr<Writer<float>> make_html_writer(const Output&);
template std::unique_ptr<Writer<double>> make_html_writer(const Output&);

}  // namespace dvdx::tool
