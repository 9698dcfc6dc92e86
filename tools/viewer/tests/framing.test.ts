import * as THREE from 'three';
import { expect, test } from 'vitest';
import { aroundNearlyAll, boxOf, framingOf, placeFor, smoothed, withBodies } from '../src/playback/framing';

const cube = (x: number, y = 0, z = 0, half = 0.5): THREE.Box3 => boxOf([x - half, y - half, z - half, x + half, y + half, z + half]);
const times = (count: number): number[] => Array.from({ length: count }, (_, i) => i / 30);

test('what swings about a place is framed whole, and not followed', () => {
  const boxes = times(60).map((time) => cube(0.5 * Math.sin(time)).union(cube(0)));
  const { extent, centers } = framingOf(boxes, times(60), 'y');
  expect(extent.x).toBeCloseTo(1 + 0.5, 2);
  expect(centers.every((center) => center.equals(centers[0]!))).toBe(true);
});

test('what walks away is followed, as large as it is', () => {
  const boxes = times(300).map((time) => cube(2 * time));
  const { extent, centers } = framingOf(boxes, times(300), 'y');
  expect(extent.x).toBeCloseTo(1);
  expect([extent.y, extent.z]).toEqual([1, 1]);
  centers.forEach((center, i) => expect(Math.abs(center.x - (2 * i) / 30)).toBeLessThan(1e-9));
});

test('a fall is framed whole, a deep one is followed', () => {
  const fall = (depth: number): THREE.Box3[] => times(60).map((_, i) => cube(0, (-depth * i) / 59));
  expect(framingOf(fall(3), times(60), 'y').extent.y).toBeCloseTo(4);
  expect(framingOf(fall(30), times(60), 'y').extent.y).toBeLessThan(12);
});

test('a single point that moves is framed on all its way', () => {
  const boxes = times(60).map((time) => cube(time, 0, 0, 0));
  expect(framingOf(boxes, times(60), 'y').extent.x).toBeCloseTo(59 / 30);
});

test('frames that burst at the end do not make the others small', () => {
  const boxes = [...times(99).map(() => cube(0)), cube(0, 0, 0, 1e6)];
  expect(aroundNearlyAll(boxes).max.x).toBe(0.5);
  expect(aroundNearlyAll(boxes.slice(60)).max.x).toBe(1e6); // one of forty is more than a fiftieth
  expect(framingOf([boxOf(undefined)], [0], 'y').extent.x).toBe(2);
});

test('bodies that are near belong to the picture, those that are far or vast do not', () => {
  const around = withBodies(cube(0), [cube(1.1), cube(9), cube(0, -1000, 0, 1000)], 2);
  expect(around.equals(cube(0).union(cube(1.1)))).toBe(true);
});

test('a path is smoothed over half a second, and goes on where nothing is', () => {
  expect(smoothed([0, 1, NaN, 8], [0, 0.2, 1, 2])).toEqual([0, 0.5, 1, 8]);
});

// By an independent path: a camera of three.js.
test('the camera sees a box whole, and no nearer one would', () => {
  const extent = new THREE.Vector3(3, 1, 2);
  const direction = new THREE.Vector3(0.5, 0.38, 0.78).normalize();
  const right = new THREE.Vector3(0, 1, 0).cross(direction).normalize();
  const above = direction.clone().cross(right);
  const camera = new THREE.PerspectiveCamera(40, 2, 0.01, 100);
  const upwards = Math.tan((20 * Math.PI) / 180);
  const place = placeFor(extent, direction, right, above, 2 * upwards, upwards);
  const target = right.clone().multiplyScalar(place.right).addScaledVector(above, place.above);
  const farthest = (distance: number): number => {
    camera.position.copy(target).addScaledVector(direction, distance);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const corners = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => new THREE.Vector3(x, y, z).multiply(extent).divideScalar(2))));
    return Math.max(...corners.flatMap((corner) => { const { x, y } = corner.project(camera); return [Math.abs(x), Math.abs(y)]; }));
  };
  expect(farthest(place.distance)).toBeCloseTo(1, 5);
  expect(farthest(0.98 * place.distance)).toBeGreaterThan(1.001);
});
