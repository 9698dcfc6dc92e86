// What the particles meet: planes and spheres.
import * as THREE from 'three';
import type { Contact, PlaneContact, SphereContact } from './scene';

export type Drawn = 'grids' | 'grids and sheets';

function plane(contact: PlaneContact, center: THREE.Vector3, size: number, ink: THREE.ColorRepresentation, drawn: Drawn): THREE.Object3D {
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

function sphere(contact: SphereContact, ink: THREE.ColorRepresentation): THREE.Object3D {
  const isInside = contact.side === 'inside';
  const material = new THREE.MeshLambertMaterial({
    color: ink,
    side: isInside ? THREE.BackSide : THREE.FrontSide,
    transparent: isInside,
    opacity: isInside ? 0.25 : 1,
  });
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(1, 64, 32), material);
  mesh.scale.setScalar(contact.radius * (isInside ? 1.005 : 0.995)); // particles rest on it, not in it
  mesh.position.set(...contact.center);
  return mesh;
}

export function surroundings(
  contacts: readonly Contact[],
  center: THREE.Vector3,
  size: number,
  ink: THREE.ColorRepresentation,
  drawn: Drawn,
): THREE.Group {
  const group = new THREE.Group();
  for (const contact of contacts) {
    group.add(contact.type === 'plane' ? plane(contact, center, size, ink, drawn) : sphere(contact, ink));
  }
  const light = new THREE.HemisphereLight(0xffffff, 0x808080, Math.PI);
  group.add(light);
  return group;
}
