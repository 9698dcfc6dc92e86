// The surface of bodies whose springs make cells with eight corners.
import type { Frame } from './frames';

const most = 200000; // lines that are searched

type Neighbours = ReadonlyMap<number, ReadonlySet<number>>;

function neighbours(lines: Iterable<readonly [number, number]>): Map<number, Set<number>> {
  const found = new Map<number, Set<number>>();
  const join = (a: number, b: number): void => void (found.get(a) ?? found.set(a, new Set()).get(a)!).add(b);
  for (const [a, b] of lines) {
    join(a, b);
    join(b, a);
  }
  return found;
}

function common(joined: Neighbours, a: number, b: number): number[] {
  const of = joined.get(b);
  return of ? [...(joined.get(a) ?? [])].filter((each) => of.has(each)) : [];
}

// Returns the lines that are no diagonals: no common neighbour of a and b sees both at a right angle or more.
function sides(lines: Uint32Array, { positions }: Frame): Map<number, Set<number>> {
  const pairs = Array.from({ length: lines.length / 2 }, (_, i) => [lines[2 * i]!, lines[2 * i + 1]!] as const);
  const all = neighbours(pairs);
  const squared = (a: number, b: number): number => {
    let sum = 0;
    for (let axis = 0; axis < 3; ++axis) sum += (positions[3 * a + axis]! - positions[3 * b + axis]!) ** 2;
    return sum;
  };
  return neighbours(
    pairs.filter(([a, b]) => {
      const long = 1.05 * squared(a, b);
      return common(all, a, b).every((c) => long < squared(a, c) + squared(c, b));
    }),
  );
}

// Returns the fourth corner of a face with `at` and two of its neighbours.
const opposite = (joined: Neighbours, at: number, a: number, b: number): number | undefined => common(joined, a, b).find((each) => each !== at);

export interface Surface {
  faces: number[]; // of each the number of its corners, four, then the corners
  inside: ReadonlySet<number>; // the particles that the cells hold
}

// Returns the sides of cells that no second cell shares; nothing if there are no cells.
export function latticeSurface(lines: Uint32Array, first: Frame): Surface {
  const inside = new Set<number>();
  if (lines.length > 2 * most) return { faces: [], inside };
  const joined = sides(lines, first);
  const quads = new Map<string, { corners: number[]; cells: number }>();
  const cells = new Set<string>();
  const add = (...corners: number[]): void => {
    const key = [...corners].sort((a, b) => a - b).join();
    const there = quads.get(key);
    if (there) ++there.cells;
    else quads.set(key, { corners, cells: 1 });
  };
  for (const [o, around] of joined) {
    const near = [...around];
    for (let i = 0; i < near.length; ++i) {
      for (let j = i + 1; j < near.length; ++j) {
        const ab = opposite(joined, o, near[i]!, near[j]!);
        if (ab === undefined) continue;
        for (let k = j + 1; k < near.length; ++k) {
          const [a, b, c] = [near[i]!, near[j]!, near[k]!];
          const bc = opposite(joined, o, b, c);
          const ca = opposite(joined, o, c, a);
          if (bc === undefined || ca === undefined) continue;
          const far = common(joined, ab, bc).find((each) => each !== b && joined.get(ca)!.has(each));
          if (far === undefined) continue;
          const corners = [o, a, b, c, ab, bc, ca, far];
          if (new Set(corners).size < 8) continue;
          const key = [...corners].sort((p, q) => p - q).join();
          if (cells.has(key)) continue;
          cells.add(key);
          corners.forEach((corner) => inside.add(corner));
          add(o, a, ab, b);
          add(o, b, bc, c);
          add(o, c, ca, a);
          add(far, ab, a, ca);
          add(far, bc, b, ab);
          add(far, ca, c, bc);
        }
      }
    }
  }
  const faces = [...quads.values()].filter((quad) => quad.cells === 1).flatMap(({ corners }) => [4, ...corners]);
  return { faces, inside };
}
