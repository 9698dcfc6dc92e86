import { expect, test } from 'vitest';
import { Picture, type Shown, drawDots } from '../src/playback/dots';
import type { Frame } from '../src/playback/frames';

const asItIs = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]; // places are those of the cube

const frame = (positions: number[], speeds: number[], onward = positions): Frame =>
  ({
    count: speeds.length,
    positions: new Float32Array(positions),
    speeds: Uint8Array.from(speeds),
    onward: new Float32Array(onward),
  }) as Frame;

const still = (now: Frame): Shown => ({ now, blend: 0, colouring: 'speed' });

// Pixel -> the place of its colour.
const found = ({ pixels }: Picture): Map<number, number> =>
  new Map([...pixels.entries()].flatMap(([pixel, word]): [number, number][] => (word === 0xffffffff ? [] : [[pixel, word & 255]])));

test('a particle is a square of pixels around its place, and its band knows from where to where', () => {
  const picture = new Picture(16, 16);
  drawDots(picture, 2, asItIs, still(frame([0.25, 0.5, 0], [7])));
  expect(found(picture)).toEqual(new Map([[11 * 16 + 9, 7], [11 * 16 + 10, 7], [12 * 16 + 9, 7], [12 * 16 + 10, 7]]));
  expect([...picture.spans]).toEqual([16, 0, 9, 11]);
});

test('between two frames it is between two places', () => {
  const picture = new Picture(8, 8);
  const shown: Shown = { ...still(frame([-0.875, 0.125, 0], [1], [0.625, 0.125, 0])), blend: 0.5 };
  drawDots(picture, 1, asItIs, shown);
  expect([...found(picture).keys()]).toEqual([4 * 8 + 3]);
});

test('the nearer one is seen, whichever is drawn first', () => {
  for (const depths of [[-0.5, 0.5], [0.5, -0.5]]) {
    const picture = new Picture(8, 8);
    drawDots(picture, 1, asItIs, still(frame([0.125, 0.125, depths[0]!, 0.125, 0.125, depths[1]!], depths.map((depth) => (depth < 0 ? 3 : 4)))));
    expect([...found(picture).values()]).toEqual([3]);
  }
});

test('what is behind the eye, too far, too near, beside the picture or not finite is not drawn', () => {
  const picture = new Picture(8, 8);
  const aside = [0, 0, 1.5, 0, 0, -1.5, 3, 0, 0, 0, -3, 0, NaN, 0, 0, 0, Infinity, 0];
  drawDots(picture, 1, asItIs, still(frame(aside, [1, 1, 1, 1, 1, 1])));
  expect(found(picture).size).toBe(0);
  expect([...picture.spans]).toEqual([8, 0]);
  const fromBehind = [...asItIs.slice(0, 15), -1];
  drawDots(picture, 1, fromBehind, still(frame([0, 0, 0], [1])));
  expect(found(picture).size).toBe(0);
});

test('a picture is drawn anew', () => {
  const picture = new Picture(8, 8);
  drawDots(picture, 1, asItIs, still(frame([-0.875, 0.125, 0], [1])));
  drawDots(picture, 1, asItIs, still(frame([0.125, 0.125, 0], [2])));
  expect([...found(picture)]).toEqual([[4 * 8 + 4, 2]]);
});
