// Particles with a size. Each is a square that faces the eye and shows the ball at its place, with the ball's depth.
import * as THREE from 'three';
import type { Frame } from './frames';

const vertexShader = /* glsl */ `
  attribute vec2 corner;
  attribute vec3 from, onward, tint;
  attribute float radius;  // m
  uniform float blend;     // of the way to the next frame
  varying vec3 colour;
  varying vec3 middle;
  varying vec2 at;
  varying float size;
  void main() {
    vec4 seen = modelViewMatrix * vec4(mix(from, onward, blend), 1.0);
    middle = seen.xyz;
    at = corner;
    size = radius;
    colour = tint;
    gl_Position = projectionMatrix * (seen + vec4(radius * corner, 0.0, 0.0));
  }`;

const fragmentShader = /* glsl */ `
  uniform mat4 projectionMatrix;
  varying vec3 colour;
  varying vec3 middle;
  varying vec2 at;
  varying float size;
  void main() {
    float squared = dot(at, at);
    if (squared > 1.0) discard;
    vec3 normal = vec3(at, sqrt(1.0 - squared));
    vec4 place = projectionMatrix * vec4(middle + size * normal, 1.0);
    gl_FragDepth = 0.5 * place.z / place.w + 0.5;
    float key = max(dot(normal, vec3(-0.50, 0.60, 0.62)), 0.0);
    float fill = max(dot(normal, vec3(0.80, -0.10, 0.59)), 0.0);
    gl_FragColor = vec4(colour * (0.42 + 0.58 * key + 0.16 * fill), 1.0);
  }`;

// Returns a particle's radius: one for all, or one for each.
export const radiusOf = (radii: number | readonly number[], particle: number): number => (typeof radii === 'number' ? radii : (radii[particle] ?? 0));

export const largestOf = (radii: number | readonly number[]): number =>
  typeof radii === 'number' ? radii : radii.reduce((most, each) => Math.max(most, each), 0);

export class Balls {
  readonly object: THREE.Mesh;
  private readonly geometry = new THREE.InstancedBufferGeometry();

  constructor(
    radii: number | readonly number[], // m
    count: number,
    blend: THREE.IUniform<number>, // shared with everything else that is drawn
  ) {
    this.geometry.setAttribute('corner', new THREE.BufferAttribute(new Float32Array([-1, -1, 1, -1, 1, 1, -1, 1]), 2));
    this.geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.add('from', new Float32Array(3 * count), 3);
    this.add('onward', new Float32Array(3 * count), 3);
    this.add('tint', new Uint8Array(4 * count), 4);
    this.add('radius', Float32Array.from({ length: count }, (_, i) => radiusOf(radii, i)), 1);
    this.object = new THREE.Mesh(this.geometry, new THREE.ShaderMaterial({ uniforms: { blend }, vertexShader, fragmentShader }));
  }

  // tints: four bytes for each particle.
  move({ count, positions, onward }: Frame, tints: Uint8Array): void {
    this.geometry.instanceCount = count;
    this.set('from', positions);
    this.set('onward', onward);
    this.set('tint', tints);
  }

  private add(name: string, values: Float32Array | Uint8Array, items: number): void {
    const attribute = new THREE.InstancedBufferAttribute(values, items, values instanceof Uint8Array);
    this.geometry.setAttribute(name, attribute.setUsage(THREE.DynamicDrawUsage));
  }

  private set(name: string, values: Float32Array | Uint8Array): void {
    const attribute = this.geometry.getAttribute(name) as THREE.InstancedBufferAttribute;
    (attribute.array as Float32Array | Uint8Array).set(values);
    attribute.needsUpdate = true;
  }
}
