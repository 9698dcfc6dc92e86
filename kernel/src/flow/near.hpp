// The search for the surfaces that a block of particles may come near in a step.
#pragma once

#include <array>
#include <cstddef>

// List.    The block's trajectories (x0, x1 and the corner between them) lie in a box; widened, it is the block's region.
//          Surfaces that cannot reach the region are not on the list. Every test of the pass would reject them there: no path
//          in the region meets them, no point of the region is inside them. So the list gives the bits of all surfaces,
//          whatever the block.
// Strays.  An impact, or a surface that holds a particle, may take it out of the region. The pass watches for that, and
//          resolves the particle's step again from the beginning with all surfaces.
// Reach.   A moving surface sees paths from where it ends. It sees a point of the region, within t of the end, up to w = t |u|
//          + t omega D away from the point, D the distance from the point of its axis, and the corner by as much again and by t
//          omega times the region's size. Its own bound is widened by that.
// Overlap. A path that crosses a sphere's tangent plane may still pass far from the sphere. Where blocks search, a trajectory
//          is near a sphere or a body only if its box overlaps the box about it. It overlaps none that the list leaves out.
// Groups.  Surfaces that follow each other in the scene form groups. Each is tested only if the region overlaps the box about
//          its group. A group with a plane, the inside of a sphere or a surface on a motion has no bound.
// Beside.  If all surfaces rest and lie in a box, a particle that is on one side of it before, after and at the corner of its
//          step touches none, as it overlaps none. A call of one step tries this first, on the axis along which the block's
//          first particle is furthest out. It steps register after register, up to the first with a particle not on that side.
//          A look at the block's box before the step would read all of it once more: 1.6 times the step by itself.
// Steps.   If all particles have the same coefficients, a step of an axis is one affine map of (x, v). It takes a rectangle of
//          them to where it takes its corners, so the boxes of many steps follow from that of the first. If nothing is near any
//          of them, the block is stepped as without contacts. Among a few planes this is also tried, if a call takes enough
//          steps to pay for the look.

namespace dvdx {

template <class T>
struct Region {
  std::array<T, 3> low{}, high{};  // m
};

struct SurfaceGroup {
  std::array<double, 3> center{}, half{};  // m: box about the group; half is infinite if nothing bounds it
};
inline constexpr std::size_t group_size = 16;

// Blocks search in scenes with more surfaces than this, and with bodies, surfaces on motions or surfaces that push out.
inline constexpr std::size_t unsearched_surfaces = 8;

// Among planes alone: the steps of a call that are tested together. Calls of fewer steps are not tested.
inline constexpr std::size_t looked_at_steps = 16;

// most_near: surfaces on a block's list. If more are near, the block is halved, down to least_block particles, which meet all.
inline constexpr std::size_t most_near = 32;
inline constexpr std::size_t least_block = 64;

}  // namespace dvdx
