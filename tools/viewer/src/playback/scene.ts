// All data that the page was given besides its frames.
import { takenText } from '../shared/page';
import { unpacked } from '../shared/bytes';
import type { HalfSpace } from './bodies';
import type { Frame } from './frames';
import { latticeSurface } from './lattice';
import { type Sheet, restLengths } from './stretch';

export type Vector = [number, number, number];

interface AnyContact {
  motion?: number; // index of the scene's motion that carries it from where it is written
}

export interface PlaneContact extends AnyContact {
  type: 'plane';
  normal: Vector;
  offset: number;
}

export interface SphereContact extends AnyContact {
  type: 'sphere';
  center: Vector;
  radius: number;
  side: 'outside' | 'inside';
}

export interface CapsuleContact extends AnyContact {
  type: 'capsule';
  ends: [Vector, Vector];
  radii: [number, number];
}

export interface BoxContact extends AnyContact {
  type: 'box';
  center: Vector;
  half_extents: Vector;
  rotation: Vector; // rad: axis times angle
  side: 'outside' | 'inside';
}

export interface ConvexContact extends AnyContact {
  type: 'convex';
  planes: HalfSpace[];
}

export interface MeshContact extends AnyContact {
  type: 'mesh';
  vertices: Vector[];
  triangles: Vector[]; // numbers of vertices
}

export type Contact = PlaneContact | SphereContact | CapsuleContact | BoxContact | ConvexContact | MeshContact;

export interface MotionKey {
  time: number; // s
  translation: Vector; // m
  rotation: Vector; // rad: axis times angle
  jump?: boolean; // the pose jumps from that of the key before
}

export interface Motion {
  center: Vector; // m
  keys: MotionKey[]; // at least one, their times ascending
}

export type Anchors = 'start' | Vector | Vector[]; // one for all particles, or one each

export interface Scene {
  every: number; // one particle in `every` is shown
  states: number;
  name?: string;
  about?: string;
  step?: number; // s
  duration?: number; // s
  method?: string;
  reference?: string;
  gravity?: Vector; // m/s^2
  contacts?: Contact[];
  motions?: Motion[];
  nets?: [number, number][]; // grids that are no cloth: the first particle, and how many
  sheets?: Sheet[];
  pins?: number[]; // particles that are held
  radii?: number | number[]; // m: of particles that are balls, one for all or one for each that is shown
  anchors?: Anchors[];
}

// Bounds over all frames.
export interface Bounds {
  low: Vector;
  high: Vector;
  speed: number; // the highest, m/s
  error: number; // the largest, m
}

// Particles that lines or triangles join.
export interface Pieces {
  corners: Uint32Array<ArrayBuffer>; // two or three for each piece
  whole?: Whole; // if some tear
}

export interface Joints {
  lines: Pieces; // ropes, nets and all else that lies in no face
  sides: Pieces; // of the triangles' faces, and other lines that join their corners
  triangles: Pieces; // of cloth, and of the surface of cells
  covered: ReadonlySet<number>; // particles that they show
  restOf: (a: number, b: number) => number; // m: the length at rest of a line, by its ends
}

// Returns how many pieces are whole in a frame. Pieces are sorted by their tears, latest first; those that never tear lead.
export type Whole = (frame: number) => number;

function parsed<T>(name: string): T {
  const text = takenText(name);
  if (text === undefined) throw new Error(`this file holds no ${name}: it is not whole`);
  return JSON.parse(text) as T;
}

export const readScene = (): Scene => parsed<Scene>('scene');
export const readBounds = (): Bounds => parsed<Bounds>('bounds');

async function numbers(name: string): Promise<Uint32Array<ArrayBuffer>> {
  const text = takenText(name);
  return text === undefined ? new Uint32Array() : new Uint32Array((await unpacked(text)).buffer);
}

// Cuts each face into a fan of triangles. A face is given as the number of its corners, then the corners.
export function triangles(faces: Uint32Array): Uint32Array<ArrayBuffer> {
  const fan: number[] = [];
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) {
    for (let corner = 2; corner < faces[at]!; ++corner) {
      fan.push(faces[at + 1]!, faces[at + corner]!, faces[at + corner + 1]!);
    }
  }
  return new Uint32Array(fan);
}

// Returns each edge of the faces once.
export function edges(faces: Uint32Array): Uint32Array<ArrayBuffer> {
  const seen = new Set<number>();
  const ends: number[] = [];
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) {
    const corners = faces[at]!;
    for (let corner = 0; corner < corners; ++corner) {
      const a = faces[at + 1 + corner]!;
      const b = faces[at + 1 + ((corner + 1) % corners)]!;
      const key = keyOf(a, b);
      if (seen.has(key)) continue;
      seen.add(key);
      ends.push(a, b);
    }
  }
  return new Uint32Array(ends);
}

export const keyOf = (a: number, b: number): number => Math.min(a, b) * 2 ** 26 + Math.max(a, b);

// Returns the frame from which on a spring is torn, by its ends. torn: a frame and two ends for each spring.
export function tornFrom(torn: Uint32Array): (a: number, b: number) => number {
  const frames = new Map<number, number>();
  for (let at = 0; at < torn.length; at += 3) frames.set(keyOf(torn[at + 1]!, torn[at + 2]!), torn[at]!);
  return (a, b) => frames.get(keyOf(a, b)) ?? Infinity;
}

// Sorts `pieces` of `corners` particles each so that those that are whole longest come first. A piece tears with the first of
// its sides.
export function sortedByTear(pieces: Uint32Array, corners: number, from: (a: number, b: number) => number): [Uint32Array<ArrayBuffer>, Whole] {
  const count = pieces.length / corners;
  const until = Float64Array.from({ length: count }, (_, piece) => {
    let first = Infinity;
    for (let k = 0; k < corners; ++k) {
      first = Math.min(first, from(pieces[piece * corners + k]!, pieces[piece * corners + ((k + 1) % corners)]!));
    }
    return first;
  });
  const order = Array.from({ length: count }, (_, piece) => piece).sort((a, b) => (until[a] === until[b] ? a - b : until[b]! - until[a]!));
  const sorted = new Uint32Array(pieces.length);
  order.forEach((piece, at) => sorted.set(pieces.subarray(piece * corners, (piece + 1) * corners), at * corners));
  const ends = order.map((piece) => until[piece]!);
  const whole: Whole = (frame) => {
    let low = 0;
    let high = count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (ends[middle]! > frame) low = middle + 1;
      else high = middle;
    }
    return low;
  };
  return [sorted, whole];
}

// Returns the frames of `from`; a line inside a face tears with the first of its sides, so that its triangles go together.
function trianglesUntil(faces: Uint32Array, from: (a: number, b: number) => number): (a: number, b: number) => number {
  const sides = new Map<number, number>();
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) {
    const corners = faces[at]!;
    let first = Infinity;
    for (let k = 0; k < corners; ++k) first = Math.min(first, from(faces[at + 1 + k]!, faces[at + 1 + ((k + 1) % corners)]!));
    for (let k = 2; k + 1 < corners; ++k) sides.set(keyOf(faces[at + 1]!, faces[at + 1 + k]!), first);
  }
  return (a, b) => sides.get(keyOf(a, b)) ?? from(a, b);
}

// Separates the faces of cloth from those of nets, which have only their sides.
function parted(faces: Uint32Array, nets: readonly [number, number][]): { cloth: Uint32Array; net: Uint32Array } {
  if (nets.length === 0) return { cloth: faces, net: new Uint32Array() };
  const cloth: number[] = [];
  const net: number[] = [];
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) {
    const corner = faces[at + 1]!;
    const isNet = nets.some(([first, count]) => corner >= first && corner < first + count);
    (isNet ? net : cloth).push(...faces.subarray(at, at + 1 + faces[at]!));
  }
  return { cloth: Uint32Array.from(cloth), net: Uint32Array.from(net) };
}

function cornersOf(faces: Uint32Array): Set<number> {
  const corners = new Set<number>();
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) faces.subarray(at + 1, at + 1 + faces[at]!).forEach((each) => corners.add(each));
  return corners;
}

const joined = (...parts: (Uint32Array | readonly number[])[]): Uint32Array<ArrayBuffer> => {
  const all = new Uint32Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
};

// Joints as the page holds them.
export interface Given {
  lines: Uint32Array; // two ends each
  rests: Float32Array; // m: their lengths at rest, or 0
  faces: Uint32Array; // of grids and meshes: of each the number of its corners, then the corners
  torn: Uint32Array; // of each spring that tears: a frame and two ends
}

// Shows lines that lie in a face or in a body of cells with its sides.
export function jointsOf({ nets = [], sheets = [] }: Pick<Scene, 'nets' | 'sheets'>, { lines: given, rests, faces, torn }: Given, first: Frame): Joints {
  const { cloth, net } = parted(faces, nets);
  const cells = latticeSurface(given, first);
  const solid = joined(cloth, cells.faces);
  const corners = cornersOf(solid);
  cells.inside.forEach((each) => corners.add(each));
  const own: number[] = [];
  const within: number[] = [];
  for (let at = 0; at < given.length; at += 2) {
    const [a, b] = [given[at]!, given[at + 1]!];
    (corners.has(a) && corners.has(b) ? within : own).push(a, b);
  }
  const from = torn.length > 0 ? tornFrom(torn) : undefined;
  const pieces = (all: Uint32Array<ArrayBuffer>, size: number, until = from): Pieces => {
    if (!until) return { corners: all };
    const [sorted, whole] = sortedByTear(all, size, until);
    return { corners: sorted, whole };
  };
  return {
    lines: pieces(joined(own, edges(net)), 2),
    sides: pieces(joined(within, edges(cloth)), 2),
    triangles: pieces(triangles(solid), 3, from && trianglesUntil(solid, from)),
    covered: corners,
    restOf: restLengths(given, rests, sheets, first),
  };
}

export async function readJoints(scene: Scene, first: Frame): Promise<Joints> {
  const given = {
    lines: await numbers('lines'),
    rests: new Float32Array((await numbers('rests')).buffer),
    faces: await numbers('faces'),
    torn: await numbers('torn'),
  };
  return jointsOf(scene, given, first);
}
