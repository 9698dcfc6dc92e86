import * as THREE from 'three';
import { expect, test } from 'vitest';
import { placement } from '../src/playback/poses';
import type { Motion, Vector } from '../src/playback/scene';

const placed = (motion: Motion, time: number, point: Vector): number[] => new THREE.Vector3(...point).applyMatrix4(placement(motion, time)).toArray();
const close = (found: number[], expected: number[]): void => expected.forEach((x, axis) => expect(found[axis]!).toBeCloseTo(x, 12));
const still: Vector = [0, 0, 0];

test('a translation is linear between keys and held outside them', () => {
  const motion: Motion = {
    center: [5, 5, 5],
    keys: [
      { time: 1, translation: still, rotation: still },
      { time: 3, translation: [2, 0, -4], rotation: still },
    ],
  };
  close(placed(motion, 0, [1, 1, 1]), [1, 1, 1]);
  close(placed(motion, 1.5, [1, 1, 1]), [1.5, 1, 0]);
  close(placed(motion, 9, [1, 1, 1]), [3, 1, -3]);
});

test('before a jump the pose is held', () => {
  const motion: Motion = {
    center: still,
    keys: [
      { time: 1, translation: still, rotation: still },
      { time: 2, translation: [8, 0, 0], rotation: still, jump: true },
      { time: 3, translation: [9, 0, 0], rotation: still },
    ],
  };
  close(placed(motion, 1.9, [1, 0, 0]), [1, 0, 0]);
  close(placed(motion, 2, [1, 0, 0]), [9, 0, 0]);
  close(placed(motion, 2.5, [1, 0, 0]), [9.5, 0, 0]);
});

test('a turn goes about the center at a constant rate, the short way round', () => {
  const motion: Motion = {
    center: [1, 0, 0],
    keys: [
      { time: 0, translation: still, rotation: [0, 0, 3] },
      { time: 2, translation: [0, 1, 0], rotation: [0, 0, -3] },
    ],
  };
  const angle = 3 + (2 * Math.PI - 6) / 4; // a quarter of the way from 3 to -3 rad, over pi
  close(placed(motion, 0.5, [2, 0, 7]), [1 + Math.cos(angle), 0.25 + Math.sin(angle), 7]);
});

test('keys that turn the other way are no jump', () => {
  const motion: Motion = {
    center: still,
    keys: [0, 1, 2, 3].map((time) => ({ time, translation: still, rotation: [0, 2 * time, 0] as Vector })),
  };
  for (const time of [0.3, 1.7, 2.5]) close(placed(motion, time, [1, 0, 0]), [Math.cos(2 * time), 0, -Math.sin(2 * time)]);
});
