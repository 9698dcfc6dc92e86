// Springs to fixed points: a line from each particle to its anchor, and a dot there.
import * as THREE from 'three';
import type { Frame } from './frames';
import type { Anchors, Vector } from './scene';

function anchorAt(anchors: Anchors, particle: number, start: Float32Array): Vector | undefined {
  if (anchors === 'start') {
    return [start[3 * particle] ?? 0, start[3 * particle + 1] ?? 0, start[3 * particle + 2] ?? 0];
  }
  return Array.isArray(anchors[0]) ? (anchors as Vector[])[particle] : (anchors as Vector);
}

export function anchorsBox(all: readonly Anchors[], first: Frame): THREE.Box3 {
  const box = new THREE.Box3();
  for (const anchors of all) {
    for (let particle = 0; particle < first.count; ++particle) {
      const anchor = anchorAt(anchors, particle, first.positions);
      if (anchor) box.expandByPoint(new THREE.Vector3(...anchor));
    }
  }
  return box;
}

export class AnchoredSprings {
  readonly object = new THREE.Group();
  private readonly springs: { particle: number; anchor: Vector }[] = [];
  private readonly ends: THREE.BufferAttribute;

  constructor(all: readonly Anchors[], first: Frame, ink: THREE.ColorRepresentation) {
    for (const anchors of all) {
      for (let particle = 0; particle < first.count; ++particle) {
        const anchor = anchorAt(anchors, particle, first.positions);
        if (anchor) this.springs.push({ particle, anchor });
      }
    }
    this.ends = new THREE.BufferAttribute(new Float32Array(6 * this.springs.length), 3);
    this.ends.setUsage(THREE.DynamicDrawUsage);
    const lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: ink }));
    lines.geometry.setAttribute('position', this.ends);
    const dots = new THREE.Points(
      new THREE.BufferGeometry().setFromPoints(this.springs.map(({ anchor }) => new THREE.Vector3(...anchor))),
      new THREE.PointsMaterial({ color: ink, size: 5, sizeAttenuation: false }),
    );
    lines.frustumCulled = false;
    dots.frustumCulled = false;
    this.object.add(lines, dots);
  }

  move({ positions, onward }: Frame, blend: number): void {
    this.springs.forEach(({ particle, anchor }, i) => {
      const at = (axis: number): number => {
        const a = positions[3 * particle + axis] ?? anchor[axis]!;
        return a + blend * ((onward[3 * particle + axis] ?? a) - a);
      };
      this.ends.setXYZ(2 * i, ...anchor);
      this.ends.setXYZ(2 * i + 1, at(0), at(1), at(2));
    });
    this.ends.needsUpdate = true;
  }
}
