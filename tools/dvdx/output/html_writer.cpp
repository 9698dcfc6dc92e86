// A page that plays the states: the viewer's page with the scene, its joints and one frame per state in script elements.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "files/bytes.hpp"
#include "files/part_file.hpp"
#include "output/base64.hpp"
#include "output/deflate.hpp"
#include "output/frame_coder.hpp"
#include "output/html_page.hpp"
#include "output/html_scene.hpp"
#include "output/writer.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

template <class Number>
std::string packed(const std::vector<Number>& numbers) {
  return base64(deflated(bytes_of(numbers)));
}

// The two ends of each line.
std::string lines_element(const Topology& topology) {
  std::vector<std::uint32_t> ends;
  for (const auto& line : topology.lines) ends.insert(ends.end(), line.begin(), line.end());
  return fmt::format("<script type=\"text/x-dvdx-lines\">{}</script>\n", packed(ends));
}

// Each line's length at rest, m, or 0.
std::string rests_element(const Output& output) {
  return fmt::format("<script type=\"text/x-dvdx-rests\">{}</script>\n", packed(rest_lengths(output)));
}

// For each face the number of its corners, then the corners.
std::string faces_element(const Topology& topology) {
  std::vector<std::uint32_t> corners;
  for (const auto& face : topology.faces) {
    corners.push_back(static_cast<std::uint32_t>(face.size()));
    corners.insert(corners.end(), face.begin(), face.end());
  }
  return fmt::format("<script type=\"text/x-dvdx-faces\">{}</script>\n", packed(corners));
}

// For each spring that tears the first frame that shows it torn, and its ends.
std::string torn_element(const Output& output, const std::vector<std::uint64_t>& steps) {
  std::vector<std::uint32_t> numbers;
  std::size_t frame = 0;
  for (const Tear& tear : *output.tears) {
    while (frame < steps.size() && steps[frame] < tear.step) ++frame;
    numbers.insert(numbers.end(), {static_cast<std::uint32_t>(frame), tear.ends[0], tear.ends[1]});
  }
  return fmt::format("<script type=\"text/x-dvdx-torn\">{}</script>\n", packed(numbers));
}

std::string bounds_element(const Bounds& bounds) {
  return json_element("bounds", {{"low", bounds.low}, {"high", bounds.high}, {"speed", bounds.speed}, {"error", bounds.error}});
}

std::string box_text(const Box& box) {
  return fmt::format("{},{},{},{},{},{}", static_cast<float>(box.low[0]), static_cast<float>(box.low[1]),
                     static_cast<float>(box.low[2]), static_cast<float>(box.high[0]), static_cast<float>(box.high[1]),
                     static_cast<float>(box.high[2]));
}

std::string frame_element(const Moment& moment, const Frame& frame) {
  return fmt::format(
      "<script type=\"text/x-dvdx-frame\" data-step=\"{}\" data-time=\"{}\" data-all=\"{}\" data-count=\"{}\" "
      "data-gone=\"{}\" data-bad=\"{}\" "
      "data-exponent=\"{}\" data-order=\"{}\" data-across=\"{}\" data-planes=\"{}\" data-speed=\"{}\" data-error=\"{}\" "
      "data-box=\"{}\">{}"
      "</script>\n",
      moment.step, moment.time, frame.all, frame.count, frame.gone, frame.bad, frame.exponent, frame.order,
      frame.difference == Difference::across ? 1 : 0, frame.planes, frame.speed, frame.error,
      frame.count > 0 ? box_text(frame.box) : "", base64(frame.bytes));
}

template <class T>
class HtmlWriter final : public Writer<T> {
 public:
  HtmlWriter(const Output& output, HtmlPage page)
      : output_(output),
        after_(std::move(page.after)),
        reference_(output.reference),
        ids_(output.ids),
        stride_(stride_of(output)),
        coder_(stride_),
        file_(output.target) {
    file_.write(page.before);
    file_.write(json_element("scene", scene_json(output)));
    file_.write(lines_element(*output.topology));
    file_.write(rests_element(output));
    file_.write(faces_element(*output.topology));
  }

  void write(const Moment& moment, const State<T>& state) override {
    const auto reference = reference_ ? reference_(moment, stride_) : std::vector<double>();
    const auto ids = ids_ ? ids_(state.count) : std::span<const std::uint32_t>();
    file_.write(frame_element(moment, coder_.code(state, reference, ids)));
    if (output_.tears != nullptr) steps_.push_back(moment.step);
  }

  void finish() override {
    if (output_.tears != nullptr) file_.write(torn_element(output_, steps_));
    file_.write(bounds_element(coder_.bounds()));
    file_.write(after_);
    file_.commit();
  }

 private:
  Output output_;
  std::vector<std::uint64_t> steps_;  // of the frames, if springs tear
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
