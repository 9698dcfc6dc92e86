import { expect, test } from 'vitest';
import type { Frame } from '../src/playback/frames';
import { latticeSurface } from '../src/playback/lattice';
import { jointsOf } from '../src/playback/scene';

// Particles of a lattice of nx by ny by nz, turned, and the lines between those that are up to `reach` steps apart along each axis.
function lattice(nx: number, ny: number, nz: number, reach: number): { lines: Uint32Array; first: Frame } {
  const places: [number, number, number][] = [];
  for (let i = 0; i < nx; ++i) for (let j = 0; j < ny; ++j) for (let k = 0; k < nz; ++k) places.push([i, j, k]);
  const lines: number[] = [];
  places.forEach((p, a) => places.forEach((q, b) => {
    const steps = p.map((x, axis) => Math.abs(x - q[axis]!));
    if (a < b && (reach === 0 ? steps.reduce((sum, s) => sum + s) === 1 : Math.max(...steps) <= reach)) lines.push(a, b);
  }));
  const turned = places.flatMap(([x, y, z]) => [0.8 * x - 0.6 * 2 * y, 0.6 * x + 0.8 * 2 * y, 1.5 * z]);
  return { lines: Uint32Array.from(lines), first: { count: places.length, positions: Float32Array.from(turned) } as Frame };
}

test.each([0, 1, 2])('a body of cells has the surface of a box, with lines of %i cells', (reach) => {
  const { lines, first } = lattice(3, 4, 5, reach);
  const { faces, inside } = latticeSurface(lines, first);
  expect(faces.length / 5).toBe(2 * (2 * 3 + 3 * 4 + 4 * 2));
  expect(inside.size).toBe(60);
  const corners = new Set(faces.filter((_, i) => i % 5 !== 0));
  expect(corners.size).toBe(60 - 1 * 2 * 3);
});

test('a flat net with diagonals, and a rope, have none', () => {
  for (const [nx, ny] of [[4, 4], [1, 9]] as const) {
    const { lines, first } = lattice(nx, ny, 1, 1);
    expect(latticeSurface(lines, first).faces).toEqual([]);
  }
});

const joints = (lines: number[], faces: number[], nets: [number, number][]) => {
  const given = { lines: Uint32Array.from(lines), rests: new Float32Array(lines.length / 2), faces: Uint32Array.from(faces), torn: new Uint32Array() };
  return jointsOf({ nets }, given, { count: 9, positions: new Float32Array(27) } as Frame);
};

test('a net is its lines, cloth its faces, and a rope at cloth is a line', () => {
  const { lines, sides, triangles, covered } = joints([3, 4], [4, 0, 1, 2, 3, 4, 5, 6, 7, 8], [[5, 4]]);
  expect([...lines.corners]).toEqual([3, 4, 5, 6, 6, 7, 7, 8, 8, 5]);
  expect([...sides.corners]).toEqual([0, 1, 1, 2, 2, 3, 3, 0]);
  expect([...triangles.corners]).toEqual([0, 1, 2, 0, 2, 3]);
  expect([...covered]).toEqual([0, 1, 2, 3]);
});
