// Pictures of the states: the last one or a series as .png, all of them in one animation as .apng.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "files/part_file.hpp"
#include "output/bodies.hpp"
#include "output/picture.hpp"
#include "output/radii.hpp"
#include "output/raster.hpp"
#include "output/writer.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {
namespace {

namespace inks {
constexpr Ink paper{0.97F, 0.965F, 0.95F};
constexpr Ink front{0.30F, 0.56F, 0.86F};
constexpr Ink back{0.96F, 0.68F, 0.34F};
constexpr Ink body{0.70F, 0.71F, 0.74F};
constexpr std::array<Ink, 2> floor{{{1.10F, 1.095F, 1.07F}, {1.02F, 1.015F, 0.99F}}};
constexpr Ink line{0.24F, 0.27F, 0.34F};
constexpr Ink dot{0.13F, 0.38F, 0.70F};
}  // namespace inks

// A state as it is drawn: positions in float32 from the first position of all, so that a scene far out keeps its digits.
struct Shot {
  Moment moment{};
  std::vector<std::array<float, 3>> places{};
};

// Leaves out the outermost loose particles, so that the picture shows nearly all of them. Joined ones are all in it.
void keep_nearly_all(std::vector<Vec3>& points) {
  constexpr double left_out = 0.005;  // at either end of each axis
  const auto few = static_cast<std::ptrdiff_t>(left_out * static_cast<double>(points.size()));
  if (few == 0) return;
  Vec3 low{};
  Vec3 high{};
  std::vector<double> along(points.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), along.begin(), [&](const Vec3& p) { return p[axis]; });
    std::nth_element(along.begin(), along.begin() + few, along.end());
    low[axis] = along[static_cast<std::size_t>(few)];
    std::nth_element(along.begin(), along.end() - 1 - few, along.end());
    high[axis] = along[along.size() - 1 - static_cast<std::size_t>(few)];
  }
  std::erase_if(points, [&](const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (p[axis] < low[axis] || p[axis] > high[axis]) return true;
    }
    return false;
  });
}

Vec3 upwards_in(const Scene& scene) {
  Vec3 gravity{};
  for (const Force& force : scene.forces) {
    if (const auto* constant = std::get_if<Constant>(&force)) gravity = sum(gravity, constant->acceleration);
  }
  const bool is_along_z = std::abs(gravity[2]) > std::abs(gravity[1]) && std::abs(gravity[2]) >= std::abs(gravity[0]);
  return is_along_z ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
}

// Everything that stays from picture to picture: bodies, camera.
class Stage {
 public:
  explicit Stage(const Output& output)
      : output_(output),
        scene_(output.scene != nullptr ? output.scene->scene : Scene{}),
        up_(upwards_in(scene_)),
        radii_(radii_of(output)) {
    for (const Contact& contact : scene_.contacts) surfaces_.push_back(surface_of(contact));
  }

  void look_at(const std::vector<Shot>& shots, const Vec3& origin) {
    constexpr std::size_t most_points = 4'000'000;
    std::size_t all = 0;
    for (const Shot& shot : shots) all += shot.places.size();
    const std::size_t stride = (radii_.empty() ? 1 : 7) * all / most_points + 1;
    std::vector<Vec3> points;
    std::size_t k = 0;
    for (const Shot& shot : shots) {
      for (const auto& place : shot.places) {
        const Vec3 point{origin[0] + place[0], origin[1] + place[1], origin[2] + place[2]};
        if (k++ % stride == 0 && is_finite(point)) points.push_back(point);
      }
    }
    if (*output_.topology == no_topology) keep_nearly_all(points);
    const Vec3 back = direction(points);
    size_ = extent(points);
    middle_ = {};
    for (const Vec3& point : points) middle_ = sum(middle_, scaled(point, 1 / static_cast<double>(points.size())));
    if (!radii_.empty()) add_ends(*std::max_element(radii_.begin(), radii_.end()), points);
    camera_ = camera_on(points, back, up_);
  }

  [[nodiscard]] Picture draw(const Shot& shot, const Vec3& origin, std::size_t width, std::size_t height) {
    Raster raster(width, height, camera_, inks::paper);
    draw_bodies(raster, shot.moment.time);
    const auto place = [&](std::size_t i) {
      const auto& at = shot.places[i];
      return Vec3{origin[0] + at[0], origin[1] + at[1], origin[2] + at[2]};
    };
    const std::size_t torn = tears_until(output_, shot.moment.step);
    if (torn != 0) left_ = without(*output_.topology, {output_.tears->data(), torn});
    const Topology& topology = torn != 0 ? left_ : *output_.topology;
    draw_faces(raster, topology, shot.places.size(), place);
    draw_loose(raster, topology, shot.places.size(), place);
    for (std::size_t i = 0; i < std::min(radii_.size(), shot.places.size()); ++i) {  // fewer if they come and go
      if (radii_[i] > 0 && is_finite(place(i))) raster.add_ball(place(i), radii_[i], inks::dot);
    }
    return raster.picture();
  }

 private:
  // Adds the ends of the balls around the points along each axis, so that they are in the picture too.
  static void add_ends(double radius, std::vector<Vec3>& points) {
    const std::size_t balls = points.size();
    points.reserve(7 * balls);
    for (std::size_t i = 0; i < balls; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const double way : {-radius, radius}) {
          points.push_back(points[i]);
          points.back()[axis] += way;
        }
      }
    }
  }
  [[nodiscard]] static double extent(const std::vector<Vec3>& points) {
    double most = 0;
    for (const Vec3& point : points) most = std::max(most, length(difference(point, points.front())));
    return most > 0 ? most : 1;
  }
  // Returns the view of a page: from the front if all is in one plane, otherwise from a little to the right and above.
  [[nodiscard]] Vec3 direction(const std::vector<Vec3>& points) const {
    const bool is_flat = std::all_of(points.begin(), points.end(), [&](const Vec3& point) {
      return std::abs(point[2] - points.front()[2]) < 0.05 * extent({points.front(), point});
    });
    if (up_[2] == 1) return {0.55, -0.75, 0.35};
    return is_flat ? Vec3{0, 0, 1} : Vec3{0.5, 0.38, 0.78};
  }

  void draw_bodies(Raster& raster, double time) const {
    for (std::size_t c = 0; c < scene_.contacts.size(); ++c) {
      const auto motion = std::visit([](const auto& shape) { return shape.motion; }, scene_.contacts[c]);
      const std::optional<Pose> pose = motion ? std::optional(pose_at(scene_.motions[*motion], time)) : std::nullopt;
      const auto moved = [&](const Patch& patch) { return pose ? carried(patch, scene_.motions[*motion], *pose) : patch; };
      for (const Patch& patch : surfaces_[c]) raster.add_triangle(moved(patch), Sides::front, inks::body, inks::body);
      if (const auto* plane = std::get_if<Plane>(&scene_.contacts[c])) draw_plane(raster, *plane, moved);
    }
  }
  // Draws a piece of the plane in tiles, around the middle of the scene.
  template <class Moved>
  void draw_plane(Raster& raster, const Plane& plane, const Moved& moved) const {
    constexpr int half = 8;  // tiles from the middle to the edge
    const Vec3 normal = unit(plane.normal);
    const Vec3 u = across(normal);
    const Vec3 w = cross(normal, u);
    const Vec3 middle = sum(middle_, scaled(normal, plane.offset - dot(normal, middle_)));
    const double side = 2.4 * size_ / static_cast<double>(2 * half);
    const auto corner = [&](int i, int j) {
      return Corner{sum(middle, sum(scaled(u, side * static_cast<double>(i)), scaled(w, side * static_cast<double>(j)))),
                    normal};
    };
    for (int i = -half; i < half; ++i) {
      for (int j = -half; j < half; ++j) {
        const Ink& ink = inks::floor[static_cast<std::size_t>((i + j + 2 * half) % 2)];
        const std::array<Corner, 4> tile{corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)};
        raster.add_triangle(moved({tile[0], tile[1], tile[2]}), Sides::front, ink, ink);
        raster.add_triangle(moved({tile[0], tile[2], tile[3]}), Sides::front, ink, ink);
      }
    }
  }

  // Draws each face as triangles about its first corner, shaded smoothly over the sides that faces share.
  template <class Place>
  static void draw_faces(Raster& raster, const Topology& topology, std::size_t count, const Place& place) {
    std::vector<Vec3> normals(topology.faces.empty() ? 0 : count);
    const auto for_each_triangle = [&](const auto& use) {
      for (const auto& face : topology.faces) {
        for (std::size_t k = 1; k + 1 < face.size(); ++k) use(face[0], face[k], face[k + 1]);
      }
    };
    for_each_triangle([&](std::size_t a, std::size_t b, std::size_t c) {
      const Vec3 area = cross(difference(place(b), place(a)), difference(place(c), place(a)));
      if (!is_finite(area)) return;
      for (const std::size_t corner : {a, b, c}) normals[corner] = sum(normals[corner], area);
    });
    for (Vec3& normal : normals) normal = unit(normal);
    for_each_triangle([&](std::size_t a, std::size_t b, std::size_t c) {
      raster.add_triangle({Corner{place(a), normals[a]}, Corner{place(b), normals[b]}, Corner{place(c), normals[c]}},
                          Sides::both, inks::front, inks::back);
    });
  }
  // Draws lines with an end that belongs to no face, and particles that nothing joins.
  template <class Place>
  void draw_loose(Raster& raster, const Topology& topology, std::size_t count, const Place& place) const {
    constexpr double line_width = 2;
    std::vector<bool> is_of_face(count);
    for (const auto& face : topology.faces) {
      for (const std::size_t corner : face) is_of_face[corner] = true;
    }
    for (const auto& [i, j] : topology.lines) {
      if (!is_of_face[i] || !is_of_face[j]) raster.add_line(place(i), place(j), line_width, inks::line);
    }
    if (!radii_.empty()) return;  // they are balls
    const auto loose = loose_particles(topology, count);
    const double size = std::clamp(20 * std::pow(static_cast<double>(loose.size()), -0.22), 1.5, 14.0);
    for (const auto& [i] : loose) {
      if (is_finite(place(i))) raster.add_dot(place(i), size, inks::dot);
    }
  }

  Output output_;
  Scene scene_;
  Vec3 up_;
  std::vector<double> radii_;  // of balls, m
  std::vector<std::vector<Patch>> surfaces_;
  Camera camera_{};
  double size_ = 1;  // m
  Vec3 middle_{};
  Topology left_{};
};

// The camera has to know all states before it can show the first.
template <class T>
class PictureWriter : public Writer<T> {
 public:
  explicit PictureWriter(const Output& output) : output_(output), stage_(output) {
    constexpr double most = 2e9;  // bytes
    const double bytes = static_cast<double>(output.states) * static_cast<double>(output.particles) * 3 * sizeof(float);
    if (bytes <= most) return;
    throw Fault(Exit::usage, fmt::format("--out {}: {} states of {} particles take {:.3g} GB while they are drawn: must be at "
                                         "most 2 GB: a larger --every or a smaller --fps draws fewer",
                                         output.target.string(), output.states, output.particles, bytes / 1e9));
  }

  void write(const Moment& moment, const State<T>& state) override {
    Shot shot{.moment = moment, .places = {}};
    shot.places.reserve(state.count);
    for (std::size_t i = 0; i < state.count; ++i) {
      const Vec3 place{state.x[0][i], state.x[1][i], state.x[2][i]};
      if (!origin_ && is_finite(place)) origin_ = place;
      const Vec3 from = difference(place, origin_.value_or(Vec3{}));
      shot.places.push_back({static_cast<float>(from[0]), static_cast<float>(from[1]), static_cast<float>(from[2])});
    }
    shots_.push_back(std::move(shot));
  }

 protected:
  void look() { stage_.look_at(shots_, origin()); }
  [[nodiscard]] Picture drawn(const Shot& shot, std::size_t width, std::size_t height) {
    return stage_.draw(shot, origin(), width, height);
  }
  [[nodiscard]] const std::vector<Shot>& shots() const noexcept { return shots_; }
  [[nodiscard]] const Output& output() const noexcept { return output_; }

 private:
  [[nodiscard]] Vec3 origin() const { return origin_.value_or(Vec3{}); }

  Output output_;
  Stage stage_;
  std::vector<Shot> shots_;
  std::optional<Vec3> origin_;  // m: the first place that is finite
};

template <class T>
class PngWriter final : public PictureWriter<T> {
 public:
  explicit PngWriter(const Output& output) : PictureWriter<T>(output), old_frames_(old_frames_of(output)) {
    for (std::uint64_t k = 0; k < output.states; ++k) {
      files_.emplace_back(output.states == 1 ? output.target : numbered(output.target, k));
    }
  }

  void finish() override {
    this->look();
    for (std::size_t k = 0; k < this->shots().size(); ++k) files_[k].write(png(this->drawn(this->shots()[k], 960, 540)));
    commit_series(files_, old_frames_);
  }

 private:
  static std::vector<std::filesystem::path> old_frames_of(const Output& output) {
    return output.states == 1 ? std::vector<std::filesystem::path>() : old_frames(output);
  }

  std::vector<std::filesystem::path> old_frames_;
  std::vector<PartFile> files_;
};

template <class T>
class ApngWriter final : public PictureWriter<T> {
 public:
  explicit ApngWriter(const Output& output) : PictureWriter<T>(output), file_(output.target) {}

  void finish() override {
    this->look();
    const auto& shots = this->shots();
    AnimatedPng pictures(shots.size());
    double seconds = 1;
    for (std::size_t k = 0; k < shots.size(); ++k) {
      if (k + 1 < shots.size()) seconds = std::abs(shots[k + 1].moment.time - shots[k].moment.time);
      file_.write(pictures.add(with_fewer_colours(this->drawn(shots[k], 480, 270)), seconds));
    }
    file_.write(AnimatedPng::end());
    file_.commit();
  }

 private:
  PartFile file_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_png_writer(const Output& output) {
  return std::make_unique<PngWriter<T>>(output);
}
template <class T>
std::unique_ptr<Writer<T>> make_apng_writer(const Output& output) {
  return std::make_unique<ApngWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_png_writer(const Output&);
template std::unique_ptr<Writer<double>> make_png_writer(const Output&);
template std::unique_ptr<Writer<float>> make_apng_writer(const Output&);
template std::unique_ptr<Writer<double>> make_apng_writer(const Output&);

}  // namespace dvdx::tool
