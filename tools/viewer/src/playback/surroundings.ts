// The surfaces that the particles meet, where they are at each moment.
import * as THREE from 'three';
import { capsule, convex, triangleMesh } from './bodies';
import { placement, turnBy } from './poses';
import type { BoxContact, Contact, Motion, PlaneContact, SphereContact } from './scene';

export type Drawn = 'grids' | 'grids and sheets';

export interface Ground {
  center: THREE.Vector3; // of all that moves
  size: number; // m: the width at which planes are drawn
  ink: THREE.ColorRepresentation;
  drawn: Drawn;
}

function plane(contact: PlaneContact, { center, size, ink, drawn }: Ground): THREE.Object3D {
  const normal = new THREE.Vector3(...contact.normal);
  const length = normal.length();
  normal.divideScalar(length);
  const group = new THREE.Group();
  const grid = new THREE.GridHelper(size, 10, ink, ink);
  grid.material.transparent = true;
  grid.material.opacity = 0.28;
  const sheet = new THREE.Mesh(
    new THREE.PlaneGeometry(size, size),
    new THREE.MeshBasicMaterial({ color: ink, transparent: true, opacity: 0.06, side: THREE.DoubleSide, depthWrite: false }),
  );
  sheet.rotateX(-Math.PI / 2);
  group.add(grid);
  if (drawn === 'grids and sheets') group.add(sheet);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), normal);
  const distance = normal.dot(center) - contact.offset;
  group.position.copy(center).addScaledVector(normal, -distance - 1e-3 * size);
  return group;
}

function skin(side: 'outside' | 'inside', { ink }: Ground): THREE.Material {
  const isInside = side === 'inside';
  return new THREE.MeshLambertMaterial({
    color: ink,
    side: isInside ? THREE.BackSide : THREE.FrontSide,
    transparent: isInside,
    opacity: isInside ? 0.25 : 1,
    polygonOffset: true, // behind the cloth that lies on it
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 4,
  });
}

// Returns the scale that moves a body's surface away from the particles, so that they rest on it, not in it.
const beside = (side: 'outside' | 'inside'): number => (side === 'inside' ? 1.005 : 0.995);

function sphere({ center, radius, side }: SphereContact, ground: Ground): THREE.Object3D {
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(1, 64, 32), skin(side, ground));
  mesh.scale.setScalar(radius * beside(side));
  mesh.position.set(...center);
  return mesh;
}

function box({ center, half_extents, rotation, side }: BoxContact, ground: Ground): THREE.Object3D {
  const [a, b, c] = half_extents;
  const mesh = new THREE.Mesh(new THREE.BoxGeometry(2 * a, 2 * b, 2 * c), skin(side, ground));
  mesh.scale.setScalar(beside(side));
  mesh.quaternion.copy(turnBy(rotation));
  mesh.position.set(...center);
  return mesh;
}

const body = (geometry: THREE.BufferGeometry, ground: Ground): THREE.Object3D => new THREE.Mesh(geometry, skin('outside', ground));

function bodyOf(contact: Contact, ground: Ground): THREE.Object3D {
  switch (contact.type) {
    case 'plane':
      return plane(contact, ground);
    case 'sphere':
      return sphere(contact, ground);
    case 'capsule':
      return body(capsule(contact.ends, contact.radii), ground);
    case 'box':
      return box(contact, ground);
    case 'convex':
      return body(convex(contact.planes), ground);
    case 'mesh':
      return body(triangleMesh(contact.vertices, contact.triangles), ground);
  }
}

interface Follower {
  object: THREE.Object3D;
  motion: Motion;
}

export class Surroundings {
  readonly object = new THREE.Group();
  private readonly followers: Follower[] = [];
  private readonly bodies: THREE.Object3D[] = []; // all but planes
  private stillBoxes: THREE.Box3[] | undefined;
  private time = NaN; // s: for which they are in their places

  constructor(contacts: readonly Contact[], motions: readonly Motion[], ground: Ground) {
    for (const contact of contacts) {
      const object = bodyOf(contact, ground);
      const motion = contact.motion === undefined ? undefined : motions[contact.motion];
      this.object.add(motion ? this.follower(object, motion) : object);
      if (contact.type !== 'plane') this.bodies.push(object);
    }
    this.object.add(new THREE.HemisphereLight(0xffffff, 0x808080, Math.PI));
  }

  // Moves the bodies to their places at a time. Returns whether anything has moved.
  move(time: number): boolean {
    if (this.followers.length === 0 || time === this.time) return false;
    this.time = time;
    for (const { object, motion } of this.followers) {
      object.matrix.copy(placement(motion, time));
      object.matrixWorldNeedsUpdate = true;
    }
    return true;
  }

  // Returns the box around each body at a time.
  bodiesAt(time: number): THREE.Box3[] {
    if (this.stillBoxes) return this.stillBoxes;
    this.move(time);
    this.object.updateMatrixWorld(true);
    const boxes = this.bodies.map((body) => new THREE.Box3().setFromObject(body));
    if (this.followers.length === 0) this.stillBoxes = boxes;
    return boxes;
  }

  private follower(body: THREE.Object3D, motion: Motion): THREE.Object3D {
    const object = new THREE.Group().add(body);
    object.matrixAutoUpdate = false;
    this.followers.push({ object, motion });
    return object;
  }
}
