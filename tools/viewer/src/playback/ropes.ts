// Lines as wide as ropes: WebGL's own lines are one pixel wide.
import * as THREE from 'three';
import type { Frame } from './frames';
import type { Pieces } from './scene';

const vertexShader = /* glsl */ `
  attribute vec2 corner; // which end, and which side of the line
  attribute vec3 from, fromNext, fromTint, to, toNext, toTint;
  uniform float blend;    // of the way to the next frame
  uniform float lift;     // nearer to the eye by so much of the way
  uniform float width;    // pixels
  uniform vec2 window;    // pixels
  varying vec3 colour;
  varying float across;
  vec3 before(vec3 end, vec3 other) { // no farther than where the picture begins
    float near = -1e-3 * length(other);
    return end.z < near ? end : mix(end, other, clamp((near - end.z) / (other.z - end.z), 0.0, 1.0));
  }
  void main() {
    vec3 a = (modelViewMatrix * vec4(mix(from, fromNext, blend), 1.0)).xyz;
    vec3 b = (modelViewMatrix * vec4(mix(to, toNext, blend), 1.0)).xyz;
    vec4 p = projectionMatrix * vec4((1.0 - lift) * before(a, b), 1.0);
    vec4 q = projectionMatrix * vec4((1.0 - lift) * before(b, a), 1.0);
    vec2 way = (q.xy / q.w - p.xy / p.w) * window;
    vec2 aside = length(way) > 0.0 ? normalize(vec2(-way.y, way.x)) : vec2(0.0);
    gl_Position = corner.x < 0.5 ? p : q;
    gl_Position.xy += corner.y * width / window * aside * gl_Position.w;
    colour = corner.x < 0.5 ? fromTint : toTint;
    across = corner.y;
  }`;

const fragmentShader = /* glsl */ `
  varying vec3 colour;
  varying float across;
  void main() { gl_FragColor = vec4(colour * (0.62 + 0.38 * sqrt(1.0 - min(1.0, across * across))), 1.0); }`;

export class Ropes {
  static readonly most = 60000; // lines: more are gathered too slowly

  readonly object: THREE.Mesh;
  private readonly geometry = new THREE.InstancedBufferGeometry();
  private readonly window = { value: new THREE.Vector2(1, 1) };

  constructor(
    private readonly pieces: Pieces, // of two ends each
    width: number, // pixels
    lift: number,
    blend: THREE.IUniform<number>, // shared with everything else that is drawn
  ) {
    const count = pieces.corners.length / 2;
    const corners = new Float32Array([0, -1, 0, 1, 1, 1, 1, -1]);
    this.geometry.setAttribute('corner', new THREE.BufferAttribute(corners, 2));
    this.geometry.setIndex([0, 1, 2, 0, 2, 3]);
    for (const end of ['from', 'to']) {
      for (const name of [end, `${end}Next`]) this.add(name, new THREE.InstancedBufferAttribute(new Float32Array(3 * count), 3));
      this.add(`${end}Tint`, new THREE.InstancedBufferAttribute(new Uint8Array(3 * count), 3, true));
    }
    const uniforms = { blend, lift: { value: lift }, width: { value: width }, window: this.window };
    this.object = new THREE.Mesh(this.geometry, new THREE.ShaderMaterial({ uniforms, vertexShader, fragmentShader, side: THREE.DoubleSide }));
  }

  resize(width: number, height: number): void {
    this.window.value.set(width, height);
  }

  // tints: four bytes for each particle.
  move({ positions, onward }: Frame, tints: Uint8Array, index: number): void {
    const { corners, whole } = this.pieces;
    const count = whole ? whole(index) : corners.length / 2;
    this.geometry.instanceCount = count;
    this.gather('from', positions, 3, 0, count);
    this.gather('fromNext', onward, 3, 0, count);
    this.gather('fromTint', tints, 4, 0, count);
    this.gather('to', positions, 3, 1, count);
    this.gather('toNext', onward, 3, 1, count);
    this.gather('toTint', tints, 4, 1, count);
  }

  private add(name: string, attribute: THREE.InstancedBufferAttribute): void {
    this.geometry.setAttribute(name, attribute.setUsage(THREE.DynamicDrawUsage));
  }

  private gather(name: string, values: Float32Array | Uint8Array, items: number, end: 0 | 1, count: number): void {
    const attribute = this.geometry.getAttribute(name) as THREE.InstancedBufferAttribute;
    const { array } = attribute;
    for (let i = 0; i < count; ++i) {
      const at = items * this.pieces.corners[2 * i + end]!;
      array[3 * i] = values[at]!;
      array[3 * i + 1] = values[at + 1]!;
      array[3 * i + 2] = values[at + 2]!;
    }
    attribute.needsUpdate = true;
  }
}
