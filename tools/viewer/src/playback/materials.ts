// One vertex shader for points, lines and faces, between two frames. Colours come with the particles, computed before: if the
// processor draws, looking up a palette for every corner is the dearer part of a picture.
import * as THREE from 'three';

const vertexShader = /* glsl */ `
  attribute vec3 next;
  attribute vec3 tint;
  uniform float blend;     // of the way to the next frame
  uniform float pointSize; // pixels at the distance where the camera looks
  uniform float focus;     // that distance, m
  uniform float lift;      // nearer to the eye by so much of the way: what lies on a face is seen
  varying vec3 colour;
  varying vec3 eye;
  void main() {
    vec4 seen = modelViewMatrix * vec4(mix(position, next, blend), 1.0);
    eye = seen.xyz;
    gl_Position = projectionMatrix * vec4((1.0 - lift) * seen.xyz, 1.0);
    gl_PointSize = clamp(pointSize * focus / max(-seen.z, 1e-30), 1.0, 96.0);
    colour = tint;
  }`;

const ballShader = /* glsl */ `
  varying vec3 colour;
  void main() {
    vec2 from = 2.0 * gl_PointCoord - 1.0;
    float squared = dot(from, from);
    if (squared > 1.0) discard;
    gl_FragColor = vec4(colour * (0.55 + 0.45 * sqrt(1.0 - squared) - 0.12 * (from.y + from.x)), 1.0);
  }`;

// A ring, which does not hide the particle that is held.
const pinShader = /* glsl */ `
  uniform vec3 ink;
  void main() {
    vec2 from = 2.0 * gl_PointCoord - 1.0;
    float squared = dot(from, from);
    if (squared > 1.0 || squared < 0.2) discard;
    gl_FragColor = vec4(ink, 1.0);
  }`;

const plainShader = /* glsl */ `
  varying vec3 colour;
  void main() { gl_FragColor = vec4(colour, 1.0); }`;

const faceShader = /* glsl */ `
  varying vec3 colour;
  varying vec3 eye;
  void main() {
    vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
    if (dot(normal, eye) > 0.0) normal = -normal;
    // From the left above and, weaker, from the right: the two sides of a fold differ, whatever their colour.
    float key = max(dot(normal, vec3(-0.50, 0.60, 0.62)), 0.0);
    float fill = max(dot(normal, vec3(0.80, -0.10, 0.59)), 0.0);
    vec3 cloth = mix(colour, vec3(1.0), 0.10);
    gl_FragColor = vec4(cloth * (0.36 + 0.66 * key + 0.20 * fill) + 0.10 * pow(key, 10.0), 1.0);
  }`;

export interface Look {
  points: THREE.ShaderMaterial;
  lines: THREE.ShaderMaterial;
  faces: THREE.ShaderMaterial;
  pins: THREE.ShaderMaterial;
  pointSize: number; // pixels
  uniforms: Record<'blend' | 'pointSize' | 'focus', THREE.IUniform<number>>;
}

export const lift = 1e-3; // of the distance
const pinSize = 7; // pixels at least

export function makeLook(pointSize: number, ink: THREE.ColorRepresentation): Look {
  const uniforms = { blend: { value: 0 }, pointSize: { value: pointSize }, focus: { value: 1 } };
  const material = (fragmentShader: string, lift: number, side: THREE.Side = THREE.FrontSide): THREE.ShaderMaterial =>
    new THREE.ShaderMaterial({ uniforms: { ...uniforms, lift: { value: lift } }, vertexShader, fragmentShader, side });
  const pins = new THREE.ShaderMaterial({
    uniforms: { ...uniforms, lift: { value: 2 * lift }, pointSize: { value: Math.max(pinSize, 1.5 * pointSize) }, ink: { value: new THREE.Color(ink) } },
    vertexShader,
    fragmentShader: pinShader,
  });
  const faces = material(faceShader, 0, THREE.DoubleSide);
  return { points: material(ballShader, lift), lines: material(plainShader, lift), faces, pins, pointSize, uniforms };
}
