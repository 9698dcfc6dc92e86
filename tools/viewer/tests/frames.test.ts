import { deflateSync } from 'node:zlib';
import { describe, expect, test } from 'vitest';
import { unpacked } from '../src/shared/bytes';
import { FrameDecoder, type FrameFacts } from '../src/playback/frames';
import { edges, sortedByTear, tornFrom, triangles } from '../src/playback/scene';

const facts = (changes: Partial<FrameFacts>): FrameFacts => ({
  step: 0, time: 0, all: 2, count: 2, gone: 0, bad: 0, exponent: -2, order: 0, isAcross: false, planes: 1, speed: 1, error: 0, box: undefined, ...changes,
});

// x of both particles, then y, then z.
const frame = (numbers: number[], changes: Partial<FrameFacts> = {}, planes = 1) => {
  const codes = numbers.map((n) => (n < 0 ? -2 * n - 1 : 2 * n));
  const bytes = Array.from({ length: planes }, (_, plane) => codes.map((code) => (code >> (8 * plane)) & 255)).flat();
  return [new Uint8Array([...bytes, 255, 51]), facts({ planes, ...changes })] as const;
};

const decodeFrame = (bytes: Uint8Array<ArrayBuffer>, of: FrameFacts) => new FrameDecoder().decode(bytes, of);

describe('a frame', () => {
  test('holds numbers of a lattice, x of all particles first', () => {
    const decoded = decodeFrame(...frame([4, -8, 1, 0, -1, 2]));
    expect([...decoded.positions]).toEqual([1, 0.25, -0.25, -2, 0, 0.5]);
    expect([...decoded.speeds]).toEqual([255, 51]);
    expect(decoded.errors).toBeUndefined();
  });

  test('of several planes has large numbers', () => {
    const decoded = decodeFrame(...frame([40000, -40000, 0, 0, 0, 1], {}, 3));
    expect([...decoded.positions]).toEqual([10000, 0, 0, -10000, 0, 0.25]);
  });

  test('may hold differences along the particles', () => {
    const decoded = decodeFrame(...frame([4, 1, 1, 1, 1, 1], { isAcross: true }));
    expect([...decoded.positions]).toEqual([1, 1.5, 2, 1.25, 1.75, 2.25]);
  });

  test('goes on from the frames before, and for new particles from 0, then from where they were', () => {
    const decoder = new FrameDecoder();
    const first = decoder.decode(new Uint8Array([8, 0, 0, 9]), facts({ count: 1 }));
    const second = decoder.decode(...frame([1, 4, 0, 0, 0, 0], { order: 1 }));
    expect([...second.positions]).toEqual([1.25, 0, 0, 1, 0, 0]);
    const third = decoder.decode(...frame([0, 0, 0, 0, 0, 4], { order: 2 }));
    expect([...third.positions]).toEqual([1.5, 0, 0, 1, 0, 1]);
    expect(first.onward).toBe(second.positions);
    expect(second.onward).toBe(third.positions);
  });

  test('that lost a particle goes on with the others, and lets the lost one fly on', () => {
    const decoder = new FrameDecoder();
    const start = decoder.decode(...frame([0, 4, 0, 0, 0, 0]));
    const moved = decoder.decode(...frame([4, 4, 0, 0, 0, 0], { order: 1 }));
    expect([...moved.positions]).toEqual([1, 0, 0, 2, 0, 0]);
    // The first is gone; the second goes on as it did, and a third comes at x = 3.
    const [bytes, about] = frame([0, 12, 0, 0, 0, 0], { order: 2, gone: 1, all: 2 });
    const left = decoder.decode(new Uint8Array([...bytes, 0b01]), about);
    expect([...left.positions]).toEqual([3, 0, 0, 3, 0, 0]);
    expect(left.errors).toBeUndefined();
    expect([...moved.onward]).toEqual([2, 0, 0, 3, 0, 0]);
    expect(start.onward).toBe(moved.positions);
    const end = decoder.decode(...frame([0, 0, 0, 0, 0, 0], { order: 2 }));
    expect([...end.positions]).toEqual([4, 0, 0, 3, 0, 0]);
  });

  test('has errors behind its speeds where there is a reference', () => {
    const decoded = decodeFrame(new Uint8Array([0, 0, 0, 7, 9]), facts({ count: 1 }));
    expect([...(decoded.errors ?? [])]).toEqual([9]);
  });
});

test('packed text is unpacked', async () => {
  const bytes = Uint8Array.from({ length: 1000 }, (_, i) => (i * i) % 251);
  expect(await unpacked(deflateSync(bytes).toString('base64'))).toEqual(bytes);
});

test('faces become fans of triangles, and each of their edges is one line', () => {
  const faces = new Uint32Array([4, 0, 1, 2, 3, 3, 1, 2, 5]);
  expect([...triangles(faces)]).toEqual([0, 1, 2, 0, 2, 3, 1, 2, 5]);
  expect([...edges(faces)]).toEqual([0, 1, 1, 2, 2, 3, 3, 0, 2, 5, 5, 1]);
});

describe('springs that tear', () => {
  const from = tornFrom(Uint32Array.from([4, 2, 1, 7, 3, 4]));

  test('are torn from a frame on, by either order of their ends', () => {
    expect([from(1, 2), from(2, 1), from(4, 3), from(1, 3)]).toEqual([4, 4, 7, Infinity]);
  });

  test('take with them the pieces that have them for a side, which stand last', () => {
    const [lines, whole] = sortedByTear(Uint32Array.from([1, 2, 0, 1, 3, 4]), 2, from);
    expect([...lines]).toEqual([0, 1, 3, 4, 1, 2]);
    expect([0, 3, 4, 6, 7, 9].map(whole)).toEqual([3, 3, 2, 2, 1, 1]);
    const [triangles, wholeTriangles] = sortedByTear(Uint32Array.from([0, 1, 2, 5, 6, 8, 3, 9, 4]), 3, from);
    expect([...triangles]).toEqual([5, 6, 8, 3, 9, 4, 0, 1, 2]);
    expect([3, 4, 7].map(wholeTriangles)).toEqual([3, 2, 1]);
  });
});
