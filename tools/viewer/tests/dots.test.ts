import { expect, test } from 'vitest';
import { Picture, type Shown, drawDots as draw, farthest, packed } from '../src/playback/dots';
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

const colours = Uint32Array.from({ length: 256 }, (_, value) => 1000 + value);
const drawDots = (picture: Picture, size: number, seen: readonly number[], shown: Shown): void => draw(picture, size, seen, shown, colours);

// Pixel, counted from the top left -> the value that its colour stands for.
const found = ({ pixels }: Picture): Map<number, number> =>
  new Map([...pixels.entries()].flatMap(([pixel, word]): [number, number][] => (word === 0 ? [] : [[pixel, word - 1000]])));

test('a particle is a square of pixels around its place', () => {
  const picture = new Picture(16, 16);
  drawDots(picture, 2, asItIs, still(frame([0.25, 0.5, 0], [7])));
  expect(found(picture)).toEqual(new Map([[3 * 16 + 9, 7], [3 * 16 + 10, 7], [4 * 16 + 9, 7], [4 * 16 + 10, 7]]));
});

test('between two frames it is between two places', () => {
  const picture = new Picture(8, 8);
  const shown: Shown = { ...still(frame([-0.875, 0.125, 0], [1], [0.625, 0.125, 0])), blend: 0.5 };
  drawDots(picture, 1, asItIs, shown);
  expect([...found(picture).keys()]).toEqual([3 * 8 + 3]);
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
  const fromBehind = [...asItIs.slice(0, 15), -1];
  drawDots(picture, 1, fromBehind, still(frame([0, 0, 0], [1])));
  expect(found(picture).size).toBe(0);
});

test('a picture is drawn anew, in front of what stands there and behind', () => {
  const ground = new Picture(8, 8);
  const [behind, before] = [3 * 8 + 4, 3 * 8 + 5];
  ground.pixels.set([1007, 1008], behind);
  ground.depths.set([0.5, -0.5], behind);
  const picture = new Picture(8, 8);
  drawDots(picture, 1, asItIs, still(frame([-0.875, 0.125, 0], [1])));
  picture.begin(ground);
  drawDots(picture, 1, asItIs, still(frame([0.125, 0.125, 0, 0.375, 0.125, 0], [2, 3])));
  expect([...found(picture)]).toEqual([[behind, 2], [before, 8]]);
  expect([...picture.depths.slice(behind, behind + 3)]).toEqual([0, -0.5, farthest]);
});

test('a colour is four bytes, red first', () => {
  expect([...new Uint8Array(new Uint32Array([packed([1, 2, 254])]).buffer)]).toEqual([1, 2, 254, 255]);
});
