import { expect, test } from 'vitest';
import type { Frame } from '../src/playback/frames';
import { Stretch, restLengths } from '../src/playback/stretch';

const frame = (...xs: number[]): Frame => ({ count: xs.length, positions: Float32Array.from(xs.flatMap((x) => [x, 0, 0])) }) as Frame;

test('a length at rest is its own, a side of its sheet, or that of the start', () => {
  const restOf = restLengths(Uint32Array.from([1, 0, 2, 3]), Float32Array.of(0.5, 0), [{ first: 4, columns: 3, count: 6, sides: [2, 4] }], frame(0, 1, 3, 7, 0, 0, 0, 0, 0, 0));
  expect([restOf(0, 1), restOf(2, 3), restOf(5, 4), restOf(4, 7)]).toEqual([0.5, 4, 2, 4]);
});

test('a particle has the stretch of its longest line that is whole', () => {
  const pieces = { corners: Uint32Array.of(0, 1, 1, 2), whole: (index: number) => (index < 5 ? 2 : 1) };
  const stretch = new Stretch([pieces], () => 1);
  expect([...stretch.of(frame(0, 1.25, 2.75), 0)]).toEqual([0.25, 0.5, 0.5]);
  expect([...stretch.of(frame(0, 1.25, 2.75), 5)]).toEqual([0.25, 0.25, 0]);
  expect([...stretch.of(frame(0, 0.5, 1), 0)]).toEqual([0, 0, 0]);
  stretch.scale([frame(0, 1.25, 2.75)]);
  expect(stretch.highest).toBe(0.5);
  expect([...stretch.bytes(frame(0, 1.25, 3.75), 0)]).toEqual([128, 255, 255]);
});
