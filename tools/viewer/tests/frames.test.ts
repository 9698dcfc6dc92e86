import { deflateSync } from 'node:zlib';
import { describe, expect, test } from 'vitest';
import { unpacked } from '../src/shared/bytes';
import { type FrameFacts, decodeFrame } from '../src/playback/frames';
import { edges, triangles } from '../src/playback/scene';

const facts = (changes: Partial<FrameFacts>): FrameFacts => ({
  step: 0, time: 0, count: 2, bad: 0, exponent: -2, order: 0, isAcross: false, planes: 1, speed: 1, error: 0, ...changes,
});

// x of both particles, then y, then z.
const frame = (numbers: number[], changes: Partial<FrameFacts> = {}, planes = 1) => {
  const codes = numbers.map((n) => (n < 0 ? -2 * n - 1 : 2 * n));
  const bytes = Array.from({ length: planes }, (_, plane) => codes.map((code) => (code >> (8 * plane)) & 255)).flat();
  return [new Uint8Array([...bytes, 255, 51]), facts({ planes, ...changes })] as const;
};

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

  test('goes on from the frames before, and from 0 for particles that were not there', () => {
    const first = decodeFrame(new Uint8Array([8, 0, 0, 9]), facts({ count: 1 }));
    const second = decodeFrame(...frame([1, 4, 0, 0, 0, 0], { order: 1 }), first);
    expect([...second.positions]).toEqual([1.25, 0, 0, 1, 0, 0]);
    const third = decodeFrame(...frame([0, 0, 0, 0, 0, 4], { order: 2 }), second, first);
    expect([...third.positions]).toEqual([1.5, 0, 0, 2, 0, 1]);
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
