// Points of few pixels, put into a picture of depths one by one: where the processor draws, WebGL takes a hundred times as long
// for a point.
import * as THREE from 'three';
import type { Colour } from '../shared/palette';
import type { Frame } from './frames';
import { type Colouring, type Highest, colourTable, valuesOf } from './tints';

const bandHeight = 8; // pixels

// Each band of the picture from its first pixel with a point to behind its last: the rest costs nothing.
const vertexShader = /* glsl */ `
  in vec2 span;
  uniform vec2 size; // of the picture, pixels
  void main() {
    vec2 corner = vec2(mix(span.x, span.y, position.x), ${bandHeight}.0 * (float(gl_InstanceID) + position.y));
    gl_Position = vec4(2.0 * corner / size - 1.0, 0.0, 1.0);
  }`;

const fragmentShader = /* glsl */ `
  precision highp usampler2D;
  uniform usampler2D picture;
  uniform sampler2D colours;
  layout(location = 0) out vec4 colour;
  void main() {
    uint found = texelFetch(picture, ivec2(gl_FragCoord.xy), 0).r;
    if (found == 0xffffffffu) discard;
    gl_FragDepth = float(found >> 8) / 16777215.0;
    colour = vec4(texelFetch(colours, ivec2(int(found & 255u), 0), 0).rgb, 1.0);
  }`;

const nothing = 0xffffffff;
const depths = 2 ** 24 - 1; // below that of nothing

// What there is to see: `blend` of the way from a frame to the next.
export interface Shown {
  now: Frame;
  blend: number;
  colouring: Colouring;
}

export class Picture {
  readonly pixels: Uint32Array<ArrayBuffer>; // rows from the bottom up; a pixel is its depth over the place of its colour
  readonly spans: Float32Array<ArrayBuffer>; // of each band, from and to; nothing where they are the same

  constructor(
    readonly width: number,
    readonly height: number,
  ) {
    this.pixels = new Uint32Array(width * height);
    this.spans = new Float32Array(2 * Math.ceil(height / bandHeight));
    this.clear();
  }

  clear(): void {
    this.pixels.fill(nothing);
    for (let i = 0; i < this.spans.length; ++i) this.spans[i] = i % 2 === 0 ? this.width : 0;
  }

  // A square that hides what is farther.
  put(left: number, low: number, size: number, word: number): void {
    const { width, height, pixels, spans } = this;
    if (!(left >= 0 && low >= 0 && left + size <= width && low + size <= height)) return;
    for (let y = low; y < low + size; ++y) {
      const band = 2 * Math.floor(y / bandHeight);
      if (left < spans[band]!) spans[band] = left;
      if (left + size > spans[band + 1]!) spans[band + 1] = left + size;
      for (let pixel = y * width + left; pixel < y * width + left + size; ++pixel) {
        if (word < pixels[pixel]!) pixels[pixel] = word;
      }
    }
  }
}

type N = number;
type Sixteen = [N, N, N, N, N, N, N, N, N, N, N, N, N, N, N, N];

// All particles as squares of `size` pixels. `seen` takes places to the cube of what is seen, its columns one after another.
export function drawDots(picture: Picture, size: number, seen: readonly number[], { now, blend, colouring }: Shown): void {
  const [ax, ay, az, aw, bx, by, bz, bw, cx, cy, cz, cw, dx, dy, dz, dw] = seen as Sixteen;
  const values = valuesOf(now, colouring);
  const from = now.positions;
  const to = now.onward;
  picture.clear();
  for (let i = 0, at = 0; i < now.count; ++i, at += 3) {
    const x = from[at]! + blend * (to[at]! - from[at]!);
    const y = from[at + 1]! + blend * (to[at + 1]! - from[at + 1]!);
    const z = from[at + 2]! + blend * (to[at + 2]! - from[at + 2]!);
    const w = aw * x + bw * y + cw * z + dw;
    const depth = (az * x + bz * y + cz * z + dz) / w;
    if (!(w > 0 && depth > -1 && depth < 1)) continue;
    const across = (1 + (ax * x + bx * y + cx * z + dx) / w) * picture.width;
    const upwards = (1 + (ay * x + by * y + cy * z + dy) / w) * picture.height;
    const word = (((0.5 + 0.5 * depth) * depths) << 8) | values[i]!;
    picture.put(Math.round(0.5 * (across - size)), Math.round(0.5 * (upwards - size)), size, word >>> 0);
  }
}

export class Dots {
  readonly object: THREE.Mesh;
  private readonly colours = new THREE.DataTexture(new Uint8Array(4 * 256), 256, 1);
  private readonly uniforms = {
    picture: { value: new THREE.DataTexture() },
    colours: { value: this.colours },
    size: { value: new THREE.Vector2() },
  };
  private readonly geometry = new THREE.InstancedBufferGeometry();
  private picture = new Picture(1, 1);
  private spans = new THREE.InstancedBufferAttribute(this.picture.spans, 2);

  constructor(private readonly size: number) {
    this.geometry.setAttribute('position', new THREE.Float32BufferAttribute([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], 3));
    this.geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const { uniforms } = this;
    this.resize(1, 1);
    this.object = new THREE.Mesh(this.geometry, new THREE.ShaderMaterial({ uniforms, vertexShader, fragmentShader, glslVersion: THREE.GLSL3 }));
  }

  resize(width: number, height: number): void {
    this.picture = new Picture(width, height);
    this.spans = new THREE.InstancedBufferAttribute(this.picture.spans, 2);
    this.geometry.dispose();
    this.geometry.setAttribute('span', this.spans);
    this.geometry.instanceCount = this.spans.count;
    const { picture, size } = this.uniforms;
    picture.value.dispose();
    picture.value = new THREE.DataTexture(this.picture.pixels, width, height, THREE.RedIntegerFormat, THREE.UnsignedIntType);
    picture.value.internalFormat = 'R32UI';
    size.value.set(width, height);
  }

  colour(frame: Frame, colouring: Colouring, highest: Highest, plain: Colour): void {
    const bytes = this.colours.image.data as Uint8Array;
    colourTable(frame, colouring, highest, plain).forEach((colour, i) => bytes.set(colour, 4 * i));
    this.colours.needsUpdate = true;
  }

  draw(camera: THREE.Camera, shown: Shown): void {
    const seen = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    drawDots(this.picture, this.size, seen.elements, shown);
    this.uniforms.picture.value.needsUpdate = true;
    this.spans.needsUpdate = true;
  }
}
