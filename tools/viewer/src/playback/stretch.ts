// The lengths of springs and rods relative to their rest lengths.
import type { Frame } from './frames';
import { type Pieces, keyOf } from './scene';

// A grid, with the rest lengths of its cells' sides, m, along its rows and down its columns.
export interface Sheet {
  first: number;
  columns: number;
  count: number;
  sides: [number, number];
}

export function distance(positions: Float32Array, a: number, b: number): number {
  return Math.hypot(positions[3 * a]! - positions[3 * b]!, positions[3 * a + 1]! - positions[3 * b + 1]!, positions[3 * a + 2]! - positions[3 * b + 2]!);
}

// Returns a line's rest length, m, by its ends: its own (0: unknown), that of a sheet's side, or its length at the start.
export function restLengths(lines: Uint32Array, own: Float32Array, sheets: readonly Sheet[], first: Frame): (a: number, b: number) => number {
  const known = new Map<number, number>();
  own.forEach((length, i) => length > 0 && known.set(keyOf(lines[2 * i]!, lines[2 * i + 1]!), length));
  return (a, b) => {
    const low = Math.min(a, b);
    const sheet = sheets.find((each) => low >= each.first && low < each.first + each.count);
    const apart = Math.abs(a - b);
    const side = sheet && (apart === 1 ? sheet.sides[0] : apart === sheet.columns ? sheet.sides[1] : undefined);
    return known.get(keyOf(a, b)) ?? side ?? distance(first.positions, a, b);
  };
}

export class Stretch {
  highest = 0; // at the palette's end: a part of the rest length
  private readonly rests: Float32Array[];

  constructor(
    private readonly pieces: readonly Pieces[], // of two ends each
    restOf: (a: number, b: number) => number,
  ) {
    this.rests = pieces.map(({ corners }) => Float32Array.from({ length: corners.length / 2 }, (_, i) => restOf(corners[2 * i]!, corners[2 * i + 1]!)));
  }

  get isKnown(): boolean {
    return this.rests.some((rests) => rests.length > 0);
  }

  // Returns for each particle the greatest stretch of its lines, as a part of the rest length.
  of({ count, positions }: Frame, index: number): Float32Array {
    const parts = new Float32Array(count);
    this.pieces.forEach(({ corners, whole }, n) => {
      const rests = this.rests[n]!;
      const left = whole ? whole(index) : rests.length;
      for (let i = 0; i < left; ++i) {
        const [a, b, rest] = [corners[2 * i]!, corners[2 * i + 1]!, rests[i]!];
        const part = rest > 0 ? distance(positions, a, b) / rest - 1 : 0;
        if (part > parts[a]!) parts[a] = part;
        if (part > parts[b]!) parts[b] = part;
      }
    });
    return parts;
  }

  // Returns the stretches in 255ths of the highest.
  bytes(frame: Frame, index: number): Uint8Array<ArrayBuffer> {
    return Uint8Array.from(this.of(frame, index), (part) => (this.highest > 0 ? Math.min(255, Math.round((255 * part) / this.highest)) : 0));
  }

  // Sets the palette's end from some of the frames: the stretch that one particle in a hundred exceeds in one frame in ten.
  scale(frames: readonly Frame[]): void {
    const every = Math.ceil(frames.length / 24);
    const highest = frames.flatMap((frame, index) => {
      if (index % every !== 0 || frame.count === 0) return [];
      const parts = this.of(frame, index).sort();
      return [parts[Math.floor(0.99 * (parts.length - 1))]!];
    });
    this.highest = highest.sort((a, b) => a - b)[Math.floor(0.9 * (highest.length - 1))] ?? 0;
  }
}
