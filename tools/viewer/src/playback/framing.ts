// The part of the world that the camera shows: nearly all that moves and the bodies near it, followed if it goes far.
import * as THREE from 'three';

export type Span = readonly [number, number, number, number, number, number]; // a box: its low corner, then its high one, m

export function boxOf(span: Span | undefined): THREE.Box3 {
  return span ? new THREE.Box3(new THREE.Vector3(span[0], span[1], span[2]), new THREE.Vector3(span[3], span[4], span[5])) : new THREE.Box3();
}

const diagonal = (box: THREE.Box3): number => (box.isEmpty() ? 0 : box.min.distanceTo(box.max));

const united = (boxes: readonly THREE.Box3[]): THREE.Box3 => boxes.reduce((all, box) => all.union(box), new THREE.Box3());

// Returns the box of all, or of all but a fiftieth if it is half as long without them: a scene that bursts is visible before.
export function aroundNearlyAll(boxes: readonly THREE.Box3[]): THREE.Box3 {
  const there = boxes.filter((box) => !box.isEmpty());
  const all = united(there);
  const left = Math.floor(there.length / 50);
  if (left === 0) return all;
  const center = united(there.slice(0, 1)).getCenter(new THREE.Vector3());
  const reach = (box: THREE.Box3): number => Math.max(box.min.distanceTo(center), box.max.distanceTo(center));
  const most = united([...there].sort((a, b) => reach(a) - reach(b)).slice(0, there.length - left));
  return 2 * diagonal(most) <= diagonal(all) ? most : all;
}

// Adds the bodies that are near the particles to their box, except bodies so large that the particles would look small.
export function withBodies(particles: THREE.Box3, bodies: readonly THREE.Box3[], size: number): THREE.Box3 {
  const reach = particles.clone().expandByScalar(0.5 * size);
  return united([particles, ...bodies.filter((body) => diagonal(body) <= 2 * size && reach.intersectsBox(body))]);
}

export interface Framing {
  extent: THREE.Vector3; // m, along each axis: what is shown at once
  centers: THREE.Vector3[]; // of each frame
}

// Returns the largest value, or twice the value that a fiftieth of them exceed if that is less.
function largestButFew(values: readonly number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  const most = sorted[Math.floor(0.98 * (sorted.length - 1))] ?? 0;
  return Math.min(sorted.at(-1) ?? 0, 2 * most);
}

// The camera follows along an axis if no place is always in view: if the gap is this many times the size that is shown at once.
const isFar = 0.15;
const isDeep = 3; // a fall is shown whole unless it is deeper

// `boxes` of the frames; `times` of them, s; `up` is the axis that gravity acts along.
export function framingOf(boxes: readonly THREE.Box3[], times: readonly number[], up: 'y' | 'z'): Framing {
  const all = aroundNearlyAll(boxes);
  if (all.isEmpty()) all.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
  const extent = all.getSize(new THREE.Vector3());
  const middle = all.getCenter(new THREE.Vector3());
  const centers = boxes.map(() => middle.clone());
  const there = boxes.filter((box) => !box.isEmpty());
  const largest = largestButFew(there.map(diagonal));
  if (!(largest > 0.05 * diagonal(all))) return { extent, centers };
  for (const axis of ['x', 'y', 'z'] as const) {
    const gap = Math.max(...there.map((box) => box.min[axis])) - Math.min(...there.map((box) => box.max[axis]));
    if (!(gap > (axis === up ? isDeep : isFar) * largest)) continue;
    const path = smoothed(boxes.map((box) => (box.isEmpty() ? NaN : 0.5 * (box.min[axis] + box.max[axis]))), times);
    path.forEach((at, i) => (centers[i]![axis] = at));
    const halves = boxes.flatMap((box, i) => (box.isEmpty() ? [] : [Math.max(box.max[axis] - path[i]!, path[i]! - box.min[axis])]));
    extent[axis] = 2 * largestButFew(halves);
  }
  return { extent, centers };
}

// Returns the mean over half a second around each time, less at the ends so that it does not lag: flutter does not shake the
// camera. A frame without particles keeps the position before it.
export function smoothed(path: readonly number[], times: readonly number[]): number[] {
  let last = path.find((at) => !Number.isNaN(at)) ?? 0;
  const whole = path.map((at) => (last = Number.isNaN(at) ? last : at));
  const apart = (i: number, j: number): number => Math.abs(times[i]! - times[j]!);
  return whole.map((_, i) => {
    const reach = (1 + 1e-9) * Math.min(0.25, apart(i, 0), apart(i, whole.length - 1));
    let [from, to] = [i, i];
    while (from > 0 && apart(i, from - 1) <= reach) --from;
    while (to + 1 < whole.length && apart(i, to + 1) <= reach) ++to;
    let sum = 0;
    for (let j = from; j <= to; ++j) sum += whole[j]!;
    return sum / (to - from + 1);
  });
}

// Returns the place from which the camera sees a box whole and as large as possible. direction: from the box to the camera;
// right, above: the axes of the picture; across, upwards: the tangents of half the angles of view. All in m: the distance to
// the point that the camera looks at, and that point relative to the box's center.
export function placeFor(
  extent: THREE.Vector3, direction: THREE.Vector3, right: THREE.Vector3, above: THREE.Vector3, across: number, upwards: number,
): { distance: number; right: number; above: number } {
  const corners = Array.from({ length: 8 }, (_, n) => new THREE.Vector3(n & 1 ? 0.5 : -0.5, n & 2 ? 0.5 : -0.5, n & 4 ? 0.5 : -0.5).multiply(extent));
  const along = (axis: THREE.Vector3, tangent: number): { distance: number; middle: number } => {
    const high = Math.max(...corners.map((at) => at.dot(axis) + tangent * at.dot(direction)));
    const low = Math.max(...corners.map((at) => -at.dot(axis) + tangent * at.dot(direction)));
    return { distance: (high + low) / (2 * tangent), middle: 0.5 * (high - low) };
  };
  const [a, b] = [along(right, across), along(above, upwards)];
  return { distance: Math.max(a.distance, b.distance), right: a.middle, above: b.middle };
}
