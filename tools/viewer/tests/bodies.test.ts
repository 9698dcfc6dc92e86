import * as THREE from 'three';
import { expect, test } from 'vitest';
import { capsule, convex, corners, triangleMesh } from '../src/playback/bodies';
import type { Vector } from '../src/playback/scene';

const points = (geometry: THREE.BufferGeometry): THREE.Vector3[] => {
  const places = geometry.getAttribute('position');
  return Array.from({ length: places.count }, (_, i) => new THREE.Vector3().fromBufferAttribute(places, i));
};

// In a body of revolution the widest ball that rolls along the line covers each point of its skin just so.
test('a tapered capsule touches both spheres and lies between', () => {
  const a = new THREE.Vector3(1, 2, 3);
  const b = new THREE.Vector3(1, 5, 7);
  const outside = points(capsule([a.toArray() as Vector, b.toArray() as Vector], [2, 1])).map((p) =>
    Math.min(...Array.from({ length: 1001 }, (_, n) => p.distanceTo(a.clone().lerp(b, n / 1000)) - (2 - n / 1000))),
  );
  expect(Math.max(...outside.map(Math.abs))).toBeLessThan(1e-5);
});

test('a cube by planes has eight corners and closes', () => {
  const sides: Vector[] = [[1, 0, 0], [-1, 0, 0], [0, 2, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
  const planes = sides.map((normal) => ({ normal, offset: 0.5 }));
  expect(corners(planes)).toHaveLength(8);
  const box = new THREE.Box3().setFromPoints(points(convex(planes)));
  expect(box.min.toArray()).toEqual([-0.5, -0.5, -0.5]);
  expect(box.max.toArray()).toEqual([0.5, 0.5, 0.5]);
});

test('a mesh keeps its vertices and turns its faces outwards as written', () => {
  const geometry = triangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]);
  expect(points(geometry)[1]!.toArray()).toEqual([1, 0, 0]);
  expect(geometry.getAttribute('normal').getZ(0)).toBe(1);
});
