import { expect, test } from 'vitest';
import { Balls, largestOf, radiusOf } from '../src/playback/balls';
import type { Frame } from '../src/playback/frames';

test('balls have one size, or one each', () => {
  expect(radiusOf(0.5, 7)).toBe(0.5);
  expect([0, 1, 2].map((particle) => radiusOf([0.25, 0.75], particle))).toEqual([0.25, 0.75, 0]);
  expect(largestOf(0.5)).toBe(0.5);
  expect(largestOf([0.25, 0.75, 0.5])).toBe(0.75);
});

test('each ball is where its particle is, on to where it goes, in its colour and at its size', () => {
  const balls = new Balls([0.25, 0.75, 1], 3, { value: 0 });
  const frame = { count: 2, positions: new Float32Array([1, 2, 3, 4, 5, 6]), onward: new Float32Array([2, 2, 3, 4, 5, 7]) } as Frame;
  balls.move(frame, new Uint8Array([1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0]));
  const geometry = balls.object.geometry as unknown as { instanceCount: number; getAttribute: (name: string) => { array: ArrayLike<number> } };
  const values = (name: string): number[] => Array.from(geometry.getAttribute(name).array);
  expect(geometry.instanceCount).toBe(2);
  expect(values('radius')).toEqual([0.25, 0.75, 1]);
  expect(values('from').slice(0, 6)).toEqual([1, 2, 3, 4, 5, 6]);
  expect(values('onward').slice(0, 6)).toEqual([2, 2, 3, 4, 5, 7]);
  expect(values('tint').slice(0, 8)).toEqual([1, 2, 3, 0, 4, 5, 6, 0]);
});
