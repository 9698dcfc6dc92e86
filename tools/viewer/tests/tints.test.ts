import { expect, test } from 'vitest';
import type { Frame } from '../src/playback/frames';
import { type Colouring, fillTints } from '../src/playback/tints';

const frame = { count: 3, speed: 2, error: 1e-3, speeds: Uint8Array.of(0, 255, 127), errors: Uint8Array.of(0, 255, 175) } as Frame;

const tints = (colouring: Colouring, speed: number): number[][] => {
  const bytes = new Uint8Array(12);
  fillTints(bytes, frame, colouring, { speed, error: 1e-3 }, [1, 0, 0.2]);
  return [0, 4, 8].map((at) => [...bytes.slice(at, at + 3)]);
};

const [lowest, highest] = [[0x3b, 0x52, 0x8b], [0xfd, 0xe7, 0x25]];

test('a palette goes from rest to the highest speed, and what is faster has its end', () => {
  expect(tints('speed', 2).slice(0, 2)).toEqual([lowest, highest]);
  expect(tints('speed', 1)[1]).toEqual(highest);
  expect(tints('speed', 4)[1]).not.toEqual(highest);
});

test('errors are on a scale of octaves, and none is its start', () => {
  const [none, largest, tenOctavesLess] = tints('error', 2);
  expect([none, largest]).toEqual([lowest, highest]);
  expect(tenOctavesLess).not.toEqual(lowest);
});

test('plain is one colour', () => {
  expect(tints('plain', 2)).toEqual([[255, 0, 51], [255, 0, 51], [255, 0, 51]]);
});
