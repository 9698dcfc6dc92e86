// Decodes the frames that tools/dvdx/output/frame_coder.hpp writes.

import type { Span } from './framing';

export interface FrameFacts {
  step: number;
  time: number; // s
  all: number; // particles
  count: number; // of them that are shown
  gone: number; // since the frame before
  bad: number; // particles that were not finite, and stay where they were
  exponent: number;
  order: number;
  isAcross: boolean;
  planes: number;
  speed: number; // the highest, m/s
  error: number; // the largest, m; 0 without a reference
  box: Span | undefined; // of nearly all, if any are shown
}

export interface Frame extends FrameFacts {
  positions: Float32Array<ArrayBuffer>; // x, y, z of each particle, m
  speeds: Uint8Array<ArrayBuffer>; // in 255ths of the highest
  errors: Uint8Array<ArrayBuffer> | undefined; // 0 is none, b is the largest times 2^((b - 255) / 8)
  stretches?: Uint8Array<ArrayBuffer>; // in 255ths of the palette's end, if they have been asked for
  onward: Float32Array<ArrayBuffer>; // positions in the next frame; of particles that are gone by then, as far on as they came
}

export function frameFacts(data: DOMStringMap): FrameFacts {
  const number = (name: string): number => Number(data[name]);
  return {
    step: number('step'),
    time: number('time'),
    all: number('all'),
    count: number('count'),
    gone: number('gone'),
    bad: number('bad'),
    exponent: number('exponent'),
    order: number('order'),
    isAcross: data['across'] === '1',
    planes: number('planes'),
    speed: number('speed'),
    error: number('error'),
    box: data['box'] ? (data['box'].split(',').map(Number) as unknown as Span) : undefined,
  };
}

// Returns the whole numbers of the planes, which are zigzag coded and may be differences along the particles.
function residuals(bytes: Uint8Array, facts: FrameFacts): Int32Array {
  const size = 3 * facts.count;
  const numbers = new Int32Array(size);
  for (let plane = 0; plane < facts.planes; ++plane) {
    const from = plane * size;
    const shift = 8 * plane;
    for (let i = 0; i < size; ++i) numbers[i]! |= bytes[from + i]! << shift;
  }
  let before = 0;
  for (let i = 0; i < size; ++i) {
    const code = numbers[i]!;
    const number = (code >>> 1) ^ -(code & 1);
    before = facts.isAcross ? before + number : number;
    numbers[i] = before;
  }
  return numbers;
}

const isMarked = (marks: Uint8Array, i: number): boolean => ((marks[i >> 3]! >> (i & 7)) & 1) === 1;

function withoutMarked(positions: Float32Array, marks: Uint8Array): Float32Array {
  const left = new Float32Array(positions.length);
  let kept = 0;
  for (let at = 0; at < positions.length; at += 3) {
    if (isMarked(marks, at / 3)) continue;
    left.set(positions.subarray(at, at + 3), kept);
    kept += 3;
  }
  return left.subarray(0, kept);
}

// Returns where the particles of a frame go until the next frame, which lacks those that are marked.
function landed(from: Float32Array, before: Float32Array, next: Float32Array, marks: Uint8Array): Float32Array<ArrayBuffer> {
  const to = new Float32Array(from.length);
  for (let at = 0, kept = 0; at < from.length; at += 3) {
    const isGone = isMarked(marks, at / 3);
    for (let axis = 0; axis < 3; ++axis) {
      const x = from[at + axis]!;
      to[at + axis] = isGone ? 2 * x - (before[at + axis] ?? x) : next[kept + axis]!;
    }
    if (!isGone) kept += 3;
  }
  return to;
}

// Decodes frames one after another, each from those before it.
export class FrameDecoder {
  private last: Frame | undefined;
  private before: Float32Array = new Float32Array(); // where the last frame's particles were in the one before it

  decode(bytes: Uint8Array<ArrayBuffer>, facts: FrameFacts): Frame {
    const { count, order, gone } = facts;
    const held: Float32Array = this.last?.positions ?? new Float32Array();
    const marks = bytes.subarray(bytes.length - (gone > 0 ? Math.ceil(held.length / 24) : 0));
    const a = gone > 0 ? withoutMarked(held, marks) : held;
    const b = gone > 0 ? withoutMarked(this.before, marks) : this.before;
    const numbers = residuals(bytes, facts);
    const spacing = 2 ** facts.exponent;
    const positions = new Float32Array(3 * count);
    for (let axis = 0; axis < 3; ++axis) {
      for (let i = 0, at = axis; i < count; ++i, at += 3) {
        let predicted = order > 0 ? (a[at] ?? 0) : 0;
        if (order === 2) predicted = 2 * predicted - (b[at] ?? predicted);
        positions[at] = predicted + numbers[axis * count + i]! * spacing;
      }
    }
    const start = facts.planes * 3 * count;
    const hasErrors = bytes.length - marks.length > start + count;
    const errors = hasErrors ? bytes.slice(start + count, start + 2 * count) : undefined;
    const frame = { ...facts, positions, speeds: bytes.slice(start, start + count), errors, onward: positions };
    if (this.last) this.last.onward = gone > 0 ? landed(held, this.before, positions, marks) : positions;
    this.last = frame;
    this.before = a;
    return frame;
  }
}
