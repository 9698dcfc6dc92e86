// Frames as tools/dvdx/output/frame_coder.hpp writes them, back to positions.

export interface FrameFacts {
  step: number;
  time: number; // s
  count: number;
  bad: number; // particles that were not finite, and stay where they were
  exponent: number;
  order: number;
  isAcross: boolean;
  planes: number;
  speed: number; // the highest, m/s
  error: number; // the largest, m; 0 without a reference
}

export interface Frame extends FrameFacts {
  positions: Float32Array<ArrayBuffer>; // x, y, z of each particle, m
  speeds: Uint8Array<ArrayBuffer>; // in 255ths of the highest
  errors: Uint8Array<ArrayBuffer> | undefined; // 0 is none, b is the largest times 2^((b - 255) / 8)
}

export function frameFacts(data: DOMStringMap): FrameFacts {
  const number = (name: string): number => Number(data[name]);
  return {
    step: number('step'),
    time: number('time'),
    count: number('count'),
    bad: number('bad'),
    exponent: number('exponent'),
    order: number('order'),
    isAcross: data['across'] === '1',
    planes: number('planes'),
    speed: number('speed'),
    error: number('error'),
  };
}

// The whole numbers of the planes: zigzag coded, and perhaps differences along the particles.
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

// `last` and `before` are the frames before this one.
export function decodeFrame(bytes: Uint8Array<ArrayBuffer>, facts: FrameFacts, last?: Frame, before?: Frame): Frame {
  const { count, order } = facts;
  const numbers = residuals(bytes, facts);
  const spacing = 2 ** facts.exponent;
  const positions = new Float32Array(3 * count);
  const a = order > 0 ? last?.positions : undefined;
  const b = order > 1 ? before?.positions : undefined;
  const held = a?.length ?? 0;
  const heldBefore = b?.length ?? 0;
  for (let axis = 0; axis < 3; ++axis) {
    for (let i = 0, at = axis; i < count; ++i, at += 3) {
      let predicted = at < held ? a![at]! : 0;
      if (order === 2) predicted = 2 * predicted - (at < heldBefore ? b![at]! : 0);
      positions[at] = predicted + numbers[axis * count + i]! * spacing;
    }
  }
  const start = facts.planes * 3 * count;
  const errors = bytes.length > start + count ? bytes.slice(start + count, start + 2 * count) : undefined;
  return { ...facts, positions, speeds: bytes.slice(start, start + count), errors };
}
