// Which of many surfaces a block of particles may come near in a step.
#pragma once

#include <array>
#include <cstddef>

// List.    The block's trajectories (x0, x1 and the corner between them) lie in a box; widened, it is the block's region. A
//          surface that cannot reach the region is not on the list. Nothing that the pass asks of it there would say yes:
//          no path in the region meets it, no point of the region is inside it. So the list gives the bits of all surfaces,
//          whatever the block.
// Strays.  An impact, or what holds a particle, may take it out of the region. That is watched; its step is then worked out
//          again from the beginning with all surfaces.
// Reach.   A surface that moves is seen from where it ends: a point of the region within t of the end is seen up to w = t
//          |u| + t omega D from there, D the distance from its axis' point, and the corner by as much again and by t omega
//          times the region's size. So much wider is the surface's own bound.
// Overlap. A path that passes a sphere by its tangent plane may pass far from it: where blocks search, a trajectory is near a
//          sphere or a body only if its box overlaps the box about it. It overlaps none that the list leaves out.
// Groups.  Surfaces that stand beside each other in the scene are looked at one by one only where the region overlaps the box
//          about their group. A group that holds a plane, the inside of a sphere or what a motion carries has no bound.
// Beside.  Where all surfaces rest and lie in a box, what is on one side of it before, after and at the corner of its step
// touches
//          none, as it overlaps none. A call of one step is tried so first: along the axis on which the block's first particle
//          is furthest out, register after register as they are stepped, up to one of which a particle is not so. A look at the
//          block's box before the step reads all of it once more: 1.6 times the step by itself.
// Steps.   Where all particles have the same coefficients, an axis' step is one affine map of (x, v), and takes a rectangle
//          of them to where it takes its corners: the boxes of many steps follow from that of the first. Where nothing is
//          near any of them, the block is stepped as without contacts. So it is beside a few planes, too, where a call takes
//          enough steps to pay for the look.

namespace dvdx {

template <class T>
struct Region {
  std::array<T, 3> low{}, high{};  // m
};

struct SurfaceGroup {
  std::array<double, 3> center{}, half{};  // m: of the box about it; half is infinite where nothing bounds it
};
inline constexpr std::size_t group_size = 16;

// Scenes of more surfaces than this search for those near a block, and so do all with bodies and where a surface moves.
inline constexpr std::size_t unsearched_surfaces = 8;

// Among planes alone, the steps of a call that are looked at together; calls of fewer steps are not.
inline constexpr std::size_t looked_at_steps = 16;

// On a block's list; where more are near, the block is halved, down to so many particles, which have all surfaces.
inline constexpr std::size_t most_near = 32;
inline constexpr std::size_t least_block = 64;

}  // namespace dvdx
