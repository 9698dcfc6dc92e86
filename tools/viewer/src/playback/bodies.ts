// Bodies that particles meet, as triangles.
import * as THREE from 'three';
import { ConvexGeometry } from 'three/addons/geometries/ConvexGeometry.js';
import type { Vector } from './scene';

// Two spheres and all between them, from (0, 0, 0) to (0, length, 0). A line touching both leans by asin((r0 - r1) / length).
export function capsuleProfile(r0: number, r1: number, length: number): THREE.Vector2[] {
  const steps = 16;
  const arc = (radius: number, at: number, from: number, to: number): THREE.Vector2[] =>
    Array.from({ length: steps + 1 }, (_, n) => {
      const angle = from + ((to - from) * n) / steps;
      return new THREE.Vector2(Math.max(0, radius * Math.cos(angle)), at + radius * Math.sin(angle));
    });
  const quarter = Math.PI / 2;
  if (length <= Math.abs(r0 - r1)) return r0 > r1 ? arc(r0, 0, -quarter, quarter) : arc(r1, length, -quarter, quarter);
  const lean = Math.asin((r0 - r1) / length);
  return [...arc(r0, 0, -quarter, lean), ...arc(r1, length, lean, quarter)];
}

export function capsule([from, to]: [Vector, Vector], [r0, r1]: [number, number]): THREE.BufferGeometry {
  const start = new THREE.Vector3(...from);
  const axis = new THREE.Vector3(...to).sub(start);
  const geometry = new THREE.LatheGeometry(capsuleProfile(r0, r1, axis.length()), 48);
  if (axis.length() > 0) geometry.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis.normalize()));
  return geometry.translate(start.x, start.y, start.z);
}

export interface HalfSpace {
  normal: Vector;
  offset: number; // m, of the unit normal
}

// Returns the points where three planes meet, unless another plane cuts them off.
export function corners(planes: readonly HalfSpace[]): THREE.Vector3[] {
  const all = planes.map(({ normal, offset }) => new THREE.Plane(new THREE.Vector3(...normal).normalize(), -offset));
  const found: THREE.Vector3[] = [];
  const near = 1e-9 * Math.max(...planes.map(({ offset }) => Math.abs(offset)), 1e-9);
  all.forEach((a, i) =>
    all.slice(i + 1).forEach((b, j) =>
      all.slice(i + j + 2).forEach((c) => {
        const across = new THREE.Vector3().crossVectors(b.normal, c.normal);
        const volume = a.normal.dot(across);
        if (Math.abs(volume) < 1e-9) return;
        const corner = across.multiplyScalar(-a.constant);
        corner.addScaledVector(new THREE.Vector3().crossVectors(c.normal, a.normal), -b.constant);
        corner.addScaledVector(new THREE.Vector3().crossVectors(a.normal, b.normal), -c.constant).divideScalar(volume);
        if (all.every((plane) => plane.distanceToPoint(corner) <= near + 1e-9 * corner.length())) found.push(corner);
      }),
    ),
  );
  return found;
}

export const convex = (planes: readonly HalfSpace[]): THREE.BufferGeometry => new ConvexGeometry(corners(planes));

export function triangleMesh(vertices: readonly Vector[], triangles: readonly Vector[]): THREE.BufferGeometry {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(vertices.flat()), 3));
  geometry.setIndex(triangles.flat());
  geometry.computeVertexNormals();
  return geometry;
}
