// The fields of a scene's structs, each described once: name, member, range, and whether a scene file must have it. Defaults
// are the structs' own. The kernel's check, the reader of scene files, tools/scene.schema.json and the tests of docs and Python
// derive from this file. Not installed: its short names are for the library and its command.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>

#include "dvdx/meet.hpp"
#include "dvdx/method.hpp"
#include "dvdx/network.hpp"
#include "dvdx/scene.hpp"
#include "dvdx/turnover.hpp"

namespace dvdx {

// The valid range of a number, or of each number of a list or vector. No range holds NaN.
struct Range {
  enum class Least : std::uint8_t { included, excluded };
  double min = std::numeric_limits<double>::lowest();
  double max = std::numeric_limits<double>::max();
  Least least = Least::included;
  std::string_view text = "a finite number";
  std::string_view in_file = text;  // for scene files, in which no number is infinite
  [[nodiscard]] constexpr bool holds(double value) const noexcept {
    return (least == Least::included ? value >= min : value > min) && value <= max;
  }
  static const Range finite, non_negative, non_negative_or_infinite, positive, unit;
};
inline constexpr Range Range::finite{};
inline constexpr Range Range::non_negative{.min = 0, .text = "a finite number >= 0"};
inline constexpr Range Range::non_negative_or_infinite{
    .min = 0, .max = std::numeric_limits<double>::infinity(), .text = "a number >= 0", .in_file = "a finite number >= 0"};
inline constexpr Range Range::positive{.min = 0, .least = Least::excluded, .text = "a finite number > 0"};
inline constexpr Range Range::unit{.min = 0, .max = 1, .text = "a number from 0 to 1"};

// The words of scene files for an enumeration's choices, in order from 0.
template <std::size_t count>
using Words = std::array<std::string_view, count>;
constexpr Words<5> words_of(Method) { return {"combined", "exact", "average_acceleration", "pulse", "symplectic_euler"}; }
constexpr Words<2> words_of(Expansion) { return {"exact", "first_order"}; }
constexpr Words<2> words_of(ContactPath) { return {"curve", "line"}; }
constexpr Words<2> words_of(Response) { return {"resume", "seed"}; }
constexpr Words<2> words_of(Side) { return {"outside", "inside"}; }
constexpr Words<5> words_of(Scheme) { return {"leapfrog", "fourth_order", "sequential", "accumulate", "auto"}; }
constexpr Words<2> words_of(SweepOrder) { return {"symmetric", "forward"}; }
constexpr Words<3> words_of(Lines) { return {"rows", "whole", "none"}; }
constexpr Words<2> words_of(PairAxis) { return {"midpoint", "start"}; }
constexpr Words<3> words_of(Bound) { return {"equal", "at_most", "at_least"}; }
constexpr Words<2> words_of(Faces) { return {"auto", "never"}; }
constexpr Words<2> words_of(NotFinite) { return {"kept", "removed"}; }
constexpr Words<2> words_of(SurvivorOrder) { return {"kept", "any"}; }
template <class E>
inline constexpr auto words = words_of(E{});
template <class E>
constexpr std::string_view word(E choice) {
  return words<E>[static_cast<std::size_t>(choice)];
}

// A scene file may omit a field, which then keeps the struct's default, unless it is required. about: text for the schema.
template <class Struct, class Value>
struct Field {
  std::string_view name;
  Value Struct::*value;
  Range range;
  std::string_view about;
  bool is_required;
  std::string_view member = name;  // its name in the struct
};
template <class Struct, class Value>
constexpr auto field(std::string_view name, Value Struct::*value, Range range = {}, std::string_view about = {}) {
  return Field<Struct, Value>{name, value, range, about, false};
}
template <class Struct, class Value>
constexpr auto required(std::string_view name, Value Struct::*value, Range range = {}, std::string_view about = {}) {
  return Field<Struct, Value>{name, value, range, about, true};
}
// A required direction of any length > 0. The reader of files normalises it.
template <class Struct>
struct Normal {
  std::string_view name;
  Vec3 Struct::*value;
};
// A key with a single valid word, which corresponds to no field of the struct.
struct OnlyWord {
  std::string_view name, word;
};
// A key that follows no rule: its reader, its check and its schema are written for it alone.
struct Key {
  std::string_view name;
};

template <class... Fields>
struct Description {
  std::string_view type;  // the word for it among others of its kind
  std::string_view name;  // in messages, with its article
  std::tuple<Fields...> fields;
};
template <class... Fields>
constexpr Description<Fields...> described(std::string_view type, std::string_view name, Fields... fields) {
  return {type, name, {fields...}};
}

inline constexpr std::string_view carried_by = "the name of the motion that carries it";

// ---- forces: each has a method

template <class Force, class... Fields>
constexpr auto described_force(std::string_view type, std::string_view name, Fields... fields) {
  return described(type, name, field("method", &Force::method), fields...);
}
constexpr auto describe(const Constant*) {
  return described_force<Constant>("constant", "a constant force", required("acceleration", &Constant::acceleration));
}
constexpr auto describe(const Polynomial*) {
  return described_force<Polynomial>("polynomial", "a polynomial force", required("acceleration", &Polynomial::acceleration));
}
constexpr auto describe(const Sinusoid*) {
  return described_force<Sinusoid>("sinusoid", "a sinusoid force", required("acceleration", &Sinusoid::acceleration),
                                   required("angular_frequency", &Sinusoid::angular_frequency),
                                   field("phase", &Sinusoid::phase));
}
constexpr auto describe(const Spring*) {
  return described_force<Spring>("spring", "a spring", required("stiffness", &Spring::stiffness, Range::non_negative),
                                 field("damping", &Spring::damping, Range::non_negative), required("anchor", &Spring::anchor));
}
constexpr auto describe(const RadialSpring*) {
  return described_force<RadialSpring>(
      "radial_spring", "a radial spring", required("stiffness", &RadialSpring::stiffness, Range::non_negative),
      field("damping", &RadialSpring::damping, Range::non_negative), required("anchor", &RadialSpring::anchor),
      required("rest_length", &RadialSpring::rest_length, Range::non_negative));
}
constexpr auto describe(const Drag*) {
  return described_force<Drag>("drag", "a drag", required("coefficient", &Drag::coefficient, Range::non_negative),
                               field("wind", &Drag::wind), field("expansion", &Drag::expansion));
}

// ---- contacts: each has a shape of its own, and a surface

template <class Contact, class... Fields>
constexpr auto described_contact(std::string_view type, std::string_view name, Fields... shape) {
  return described(type, name, shape..., field("restitution", &Contact::restitution, Range::unit),
                   field("friction", &Contact::friction, Range::non_negative_or_infinite),
                   field("viscosity", &Contact::viscosity, Range::non_negative_or_infinite),
                   field("normal_viscosity", &Contact::normal_viscosity, Range::non_negative_or_infinite),
                   field("response", &Contact::response), field("sweep", &Contact::sweep),
                   field("thickness", &Contact::thickness, Range::non_negative, "m that particles are kept off the surface"),
                   field("push_out", &Contact::push_out, Range::positive, "m/s at which what is inside leaves"),
                   field("motion", &Contact::motion, {}, carried_by));
}
constexpr auto describe(const Plane*) {
  return described_contact<Plane>("plane", "a plane", Normal<Plane>{"normal", &Plane::normal},
                                  required("offset", &Plane::offset));
}
constexpr auto describe(const Sphere*) {
  return described_contact<Sphere>("sphere", "a sphere", required("center", &Sphere::center),
                                   required("radius", &Sphere::radius, Range::positive), field("side", &Sphere::side));
}
constexpr auto describe(const Capsule*) {
  return described_contact<Capsule>("capsule", "a capsule", required("ends", &Capsule::ends),
                                    required("radius", &Capsule::radius, Range::positive), OnlyWord{"side", "outside"});
}
constexpr auto describe(const OrientedBox*) {
  return described_contact<OrientedBox>("box", "a box", required("center", &OrientedBox::center),
                                        required("half_extents", &OrientedBox::half_extents, Range::positive),
                                        field("rotation", &OrientedBox::rotation, {}, "rad: axis times angle"),
                                        field("side", &OrientedBox::side));
}
constexpr auto describe(const Face*) {
  return described("", "a plane of a convex body", Normal<Face>{"normal", &Face::normal}, required("offset", &Face::offset));
}
constexpr auto describe(const Convex*) {
  return described_contact<Convex>("convex", "a convex body", required("planes", &Convex::planes), OnlyWord{"side", "outside"});
}
constexpr auto describe(const TriangleMesh*) {
  return described_contact<TriangleMesh>("mesh", "a mesh", Key{"file"}, Key{"cell"}, OnlyWord{"side", "outside"});
}

// ---- motions and air

constexpr auto describe(const MotionKey*) {
  return described("", "a key of a motion", required("time", &MotionKey::time, {}, "s, later than that of the key before"),
                   field("translation", &MotionKey::translation, {}, "m"),
                   field("rotation", &MotionKey::rotation, {}, "rad: axis times angle"), Key{"jump"});
}
constexpr auto describe(const Gust*) {
  return described("", "a gust", required("amplitude", &Gust::amplitude, {}, "m/s"),
                   required("angular_frequency", &Gust::angular_frequency, {}, "rad/s"),
                   field("phase", &Gust::phase, {}, "rad"));
}
constexpr auto describe(const Wind*) {
  return described("", "a wind", field("mean", &Wind::mean), field("gusts", &Wind::gusts));
}
constexpr auto describe(const Aerodynamics*) {
  // The limit keeps the result of a pulse finite.
  constexpr Range coefficient{.min = 0, .max = 1e6, .text = "a number from 0 to 1e+06", .in_file = "a number from 0 to 1e6"};
  return described("", "the aerodynamics of a network",
                   field("density", &Aerodynamics::density, Range::non_negative, "kg/m^3, of the air"),
                   field("drag", &Aerodynamics::drag, coefficient), field("lift", &Aerodynamics::lift, coefficient));
}

// ---- particles that come and go

// The keys of every emitter, after those of its shape.
constexpr auto describe(const Emitter*) {
  return described("", "an emitter", required("rate", &Emitter::rate, Range::non_negative, "particles/s"),
                   field("start", &Emitter::start, {}, "s"), Key{"end"}, field("velocity", &Emitter::velocity, {}, "m/s"),
                   Key{"spread"}, Key{"lifetime"}, Key{"seed"}, field("motion", &Emitter::motion, {}, carried_by));
}
constexpr auto describe(const Removal*) {
  return described("", "a removal", Key{"boundaries"}, Key{"outside"}, field("not_finite", &Removal::not_finite),
                   field("order", &Removal::order));
}

// ---- networks, tethers and meetings

// The keys of a grid besides those of all networks.
constexpr auto describe(const Grid*) {
  return described("grid", "a grid", field("structural", &Grid::structural, Range::non_negative),
                   field("shear", &Grid::shear, Range::non_negative), field("bend", &Grid::bend, Range::non_negative),
                   field("damping", &Grid::damping, Range::non_negative));
}
// The keys of every network that set the coupling.
constexpr auto describe(const Coupling*) {
  return described("", "coupling", field("scheme", &Coupling::scheme), Key{"substeps"}, Key{"most_substeps"}, Key{"theta"},
                   Field<Coupling, SweepOrder>{"sweep", &Coupling::sweeps, {}, {}, false, "sweeps"},
                   field("lines", &Coupling::lines), field("method", &Coupling::method), field("axis", &Coupling::axis));
}
constexpr auto describe(const Tethers*) {
  return described("", "tethers", Key{"network"},
                   field("stretch", &Tethers::stretch, Range{.min = 1, .text = "a finite number >= 1"}));
}
constexpr auto describe(const Meet*) {
  return described(
      "", "meet", Key{"radius"}, Key{"thickness"}, Key{"part_of_cells"}, field("restitution", &Meet::restitution, Range::unit),
      field("friction", &Meet::friction, Range::non_negative, "Coulomb's coefficient"),
      field("rounds", &Meet::rounds, Range{.min = 1, .max = 64, .text = "a whole number from 1 to 64"}, "a sub-step"),
      field("most_neighbours", &Meet::most_neighbours, Range{.min = 1, .max = 255, .text = "a whole number from 1 to 255"},
            "of a particle; a longer list stops the run"),
      Key{"apart_at_start"}, Key{"groups"});
}

// ---- derived from the descriptions

template <class Struct>
inline constexpr auto description = describe(static_cast<const Struct*>(nullptr));

// Calls visit(field) for each field of a struct, in the order of a file's keys.
template <class Struct, class Visit>
constexpr void for_each_field(const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, description<Struct>.fields);
}

// The words for the alternatives of a variant, in its order.
template <class Variant>
inline constexpr std::array<std::string_view, 0> type_words{};
template <class... Structs>
inline constexpr std::array<std::string_view, sizeof...(Structs)> type_words<std::variant<Structs...>>{
    description<Structs>.type...};

}  // namespace dvdx
