// The words that scenes and the command line use for the choices of the library.
#pragma once

#include <array>
#include <string_view>
#include <variant>

#include "dvdx/method.hpp"
#include "dvdx/network.hpp"
#include "dvdx/scene.hpp"
#include "scene_io/fields.hpp"

namespace dvdx::tool {

enum class ForceType { constant, polynomial, sinusoid, spring, radial_spring, drag };
inline constexpr std::array<Named<ForceType>, 6> force_types{{{"constant", ForceType::constant},
                                                              {"polynomial", ForceType::polynomial},
                                                              {"sinusoid", ForceType::sinusoid},
                                                              {"spring", ForceType::spring},
                                                              {"radial_spring", ForceType::radial_spring},
                                                              {"drag", ForceType::drag}}};
static_assert(force_types.size() == std::variant_size_v<Force>, "a type for each force, in the variant's order");

enum class ContactType { plane, sphere, capsule, box, convex, mesh };
inline constexpr std::array<Named<ContactType>, 6> contact_types{{{"plane", ContactType::plane},
                                                                  {"sphere", ContactType::sphere},
                                                                  {"capsule", ContactType::capsule},
                                                                  {"box", ContactType::box},
                                                                  {"convex", ContactType::convex},
                                                                  {"mesh", ContactType::mesh}}};
static_assert(contact_types.size() == std::variant_size_v<Contact>, "a type for each contact, in the variant's order");

inline constexpr std::array<Named<Method>, 5> methods{{{"combined", Method::combined},
                                                       {"exact", Method::exact},
                                                       {"average_acceleration", Method::average_acceleration},
                                                       {"pulse", Method::pulse},
                                                       {"symplectic_euler", Method::symplectic_euler}}};
inline constexpr std::array<Named<Expansion>, 2> expansions{
    {{"exact", Expansion::exact}, {"first_order", Expansion::first_order}}};
inline constexpr std::array<Named<ContactPath>, 2> sweeps{{{"curve", ContactPath::curve}, {"line", ContactPath::line}}};
inline constexpr std::array<Named<Response>, 2> responses{{{"resume", Response::resume}, {"seed", Response::end_on_surface}}};
inline constexpr std::array<Named<Side>, 2> body_sides{{{"outside", Side::outside}, {"inside", Side::inside}}};
inline constexpr std::array<Named<Scheme>, 5> schemes{{{"leapfrog", Scheme::leapfrog},
                                                       {"fourth_order", Scheme::fourth_order},
                                                       {"sequential", Scheme::sequential},
                                                       {"accumulate", Scheme::accumulate},
                                                       {"auto", Scheme::automatic}}};
inline constexpr std::array<Named<SweepOrder>, 2> sweep_orders{
    {{"symmetric", SweepOrder::symmetric}, {"forward", SweepOrder::forward}}};
inline constexpr std::array<Named<dvdx::Faces>, 2> face_choices{
    {{"auto", dvdx::Faces::automatic}, {"never", dvdx::Faces::never}}};
inline constexpr std::array<Named<dvdx::Lines>, 3> line_choices{
    {{"rows", dvdx::Lines::rows}, {"whole", dvdx::Lines::whole}, {"none", dvdx::Lines::none}}};
inline constexpr std::array<Named<PairAxis>, 2> pair_axes{{{"midpoint", PairAxis::midpoint}, {"start", PairAxis::start}}};
inline constexpr std::array<Named<Bound>, 3> bounds{
    {{"equal", Bound::equal}, {"at_most", Bound::at_most}, {"at_least", Bound::at_least}}};
inline constexpr std::uint64_t most_substeps = 1000000;  // a step

template <class E, std::size_t N>
[[nodiscard]] constexpr std::string_view name_in(const std::array<Named<E>, N>& table, E value) noexcept {
  for (const auto& entry : table) {
    if (entry.value == value) return entry.name;
  }
  return "?";
}

}  // namespace dvdx::tool
