// One vertex shader for points, lines and faces: between two frames, and coloured by what each particle carries.
import * as THREE from 'three';
import { type Colour, rising } from '../shared/palette';

export type Colouring = 'plain' | 'speed' | 'error';

const vertexShader = /* glsl */ `
  attribute vec3 next;
  attribute float shade;
  uniform float blend;      // of the way to the next frame
  uniform float pointSize;  // pixels at the distance where the camera looks
  uniform float focus;      // that distance, m
  uniform int colouring;    // 0 plain, 1 by speed, 2 by error
  uniform float shadeScale; // speed: the frame's highest over all frames'; error: log2 of the same
  uniform float shadeSpan;  // error: octaves that the palette spans
  uniform vec3 plain;
  uniform sampler2D palette;
  varying vec3 colour;
  varying vec3 eye;

  float height() {
    if (colouring == 1) return shade * shadeScale;
    return shade == 0.0 ? 0.0 : 1.0 + (shadeScale + (255.0 * shade - 255.0) / 8.0) / shadeSpan;
  }

  void main() {
    vec4 seen = modelViewMatrix * vec4(mix(position, next, blend), 1.0);
    eye = seen.xyz;
    gl_Position = projectionMatrix * seen;
    gl_PointSize = clamp(pointSize * focus / max(-seen.z, 1e-30), 1.0, 96.0);
    colour = colouring == 0 ? plain : texture2D(palette, vec2(clamp(height(), 0.002, 0.998), 0.5)).rgb;
  }`;

const pointShader = /* glsl */ `
  uniform float pointSize;
  varying vec3 colour;
  varying vec3 eye;
  void main() {
    vec2 from = 2.0 * gl_PointCoord - 1.0;
    float squared = dot(from, from);
    if (squared > 1.0) discard;
    float light = pointSize < 3.0 ? 1.0 : 0.55 + 0.45 * sqrt(1.0 - squared) - 0.12 * (from.y + from.x);
    gl_FragColor = vec4(colour * light, 1.0);
  }`;

const lineShader = /* glsl */ `
  varying vec3 colour;
  varying vec3 eye;
  void main() { gl_FragColor = vec4(colour, 1.0); }`;

const faceShader = /* glsl */ `
  varying vec3 colour;
  varying vec3 eye;
  void main() {
    vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
    float facing = abs(dot(normal, normalize(vec3(0.25, 0.55, 0.8))));
    gl_FragColor = vec4(colour * (0.42 + 0.58 * facing), 1.0);
  }`;

function paletteTexture(colours: readonly Colour[]): THREE.DataTexture {
  const bytes = new Uint8Array(colours.flatMap((colour) => [...colour.map((part) => Math.round(255 * part)), 255]));
  const texture = new THREE.DataTexture(bytes, colours.length, 1);
  texture.minFilter = THREE.LinearFilter;
  texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

export interface Look {
  points: THREE.ShaderMaterial;
  lines: THREE.ShaderMaterial;
  faces: THREE.ShaderMaterial;
  uniforms: Record<string, THREE.IUniform>;
}

export function makeLook(plain: Colour): Look {
  const uniforms: Record<string, THREE.IUniform> = {
    blend: { value: 0 },
    pointSize: { value: 4 },
    focus: { value: 1 },
    colouring: { value: 1 },
    shadeScale: { value: 1 },
    shadeSpan: { value: 24 },
    plain: { value: new THREE.Vector3(...plain) },
    palette: { value: paletteTexture(rising) },
  };
  const material = (fragmentShader: string, side: THREE.Side = THREE.FrontSide): THREE.ShaderMaterial =>
    new THREE.ShaderMaterial({ uniforms, vertexShader, fragmentShader, side });
  const faces = material(faceShader, THREE.DoubleSide);
  faces.polygonOffset = true; // so that the springs in a face are seen
  faces.polygonOffsetFactor = 1;
  faces.polygonOffsetUnits = 1;
  return { points: material(pointShader), lines: material(lineShader), faces, uniforms };
}
