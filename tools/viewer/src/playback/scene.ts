// What the page was given besides its frames.
import { takenText } from '../shared/page';
import { unpacked } from '../shared/bytes';
import type { HalfSpace } from './bodies';

export type Vector = [number, number, number];

interface AnyContact {
  motion?: number; // of the scene's, which carries it from where it is written
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
  pins?: number[]; // particles that are held
  anchors?: Anchors[];
}

// Over all frames.
export interface Bounds {
  low: Vector;
  high: Vector;
  speed: number; // the highest, m/s
  error: number; // the largest, m
}

export interface Joints {
  lines: Uint32Array<ArrayBuffer>; // two ends each
  triangles: Uint32Array<ArrayBuffer>;
}

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

// Faces stand as the number of their corners and the corners; each becomes a fan.
export function triangles(faces: Uint32Array): Uint32Array<ArrayBuffer> {
  const fan: number[] = [];
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) {
    for (let corner = 2; corner < faces[at]!; ++corner) {
      fan.push(faces[at + 1]!, faces[at + corner]!, faces[at + corner + 1]!);
    }
  }
  return new Uint32Array(fan);
}

// Each edge of the faces once.
export function edges(faces: Uint32Array): Uint32Array<ArrayBuffer> {
  const seen = new Set<number>();
  const ends: number[] = [];
  for (let at = 0; at < faces.length; at += 1 + faces[at]!) {
    const corners = faces[at]!;
    for (let corner = 0; corner < corners; ++corner) {
      const a = faces[at + 1 + corner]!;
      const b = faces[at + 1 + ((corner + 1) % corners)]!;
      const key = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
      if (seen.has(key)) continue;
      seen.add(key);
      ends.push(a, b);
    }
  }
  return new Uint32Array(ends);
}

export async function readJoints(): Promise<Joints> {
  const lines = await numbers('lines');
  const faces = await numbers('faces');
  return { lines: lines.length > 0 ? lines : edges(faces), triangles: triangles(faces) };
}
