// Points of few pixels, put into the page's picture one by one. If the processor draws, WebGL takes a hundred times as long for
// a point.
import * as THREE from 'three';
import type { Colour } from '../shared/palette';
import type { Frame } from './frames';
import { type Colouring, valuesOf } from './tints';

// The moment to show: `blend` of the way from a frame to the next.
export interface Shown {
  now: Frame;
  blend: number;
  colouring: Colouring;
}

export const farthest = 2; // behind everything: depths are from -1 to 1

// Rows of pixels from the top down, and the depth of each pixel.
export class Picture {
  readonly pixels: Uint32Array<ArrayBuffer>; // red in the lowest byte, then green, blue, 255
  readonly depths: Float32Array<ArrayBuffer>;

  constructor(
    readonly width: number,
    readonly height: number,
  ) {
    this.pixels = new Uint32Array(width * height);
    this.depths = new Float32Array(width * height).fill(farthest);
  }

  // Restarts from the ground, which has everything except the points.
  begin(ground: Picture): void {
    this.pixels.set(ground.pixels);
    this.depths.set(ground.depths);
  }

  // Draws a square that hides anything deeper.
  put(left: number, top: number, size: number, depth: number, colour: number): void {
    const { width, height, pixels, depths } = this;
    if (!(left >= 0 && top >= 0 && left + size <= width && top + size <= height)) return;
    for (let y = top; y < top + size; ++y) {
      for (let pixel = y * width + left; pixel < y * width + left + size; ++pixel) {
        if (depth >= depths[pixel]!) continue;
        depths[pixel] = depth;
        pixels[pixel] = colour;
      }
    }
  }
}

export const packed = ([red, green, blue]: Colour): number => (0xff000000 | (blue << 16) | (green << 8) | red) >>> 0;

type N = number;
type Sixteen = [N, N, N, N, N, N, N, N, N, N, N, N, N, N, N, N];

// Draws all particles as squares of `size` pixels. seen: the matrix from positions to clip space, column after column. colours:
// by the value, 0 to 255, of the colouring.
export function drawDots(picture: Picture, size: number, seen: readonly number[], { now, blend, colouring }: Shown, colours: Uint32Array): void {
  const [ax, ay, az, aw, bx, by, bz, bw, cx, cy, cz, cw, dx, dy, dz, dw] = seen as Sixteen;
  const values = valuesOf(now, colouring);
  const from = now.positions;
  const to = now.onward;
  for (let i = 0, at = 0; i < now.count; ++i, at += 3) {
    const x = from[at]! + blend * (to[at]! - from[at]!);
    const y = from[at + 1]! + blend * (to[at + 1]! - from[at + 1]!);
    const z = from[at + 2]! + blend * (to[at + 2]! - from[at + 2]!);
    const w = aw * x + bw * y + cw * z + dw;
    const depth = (az * x + bz * y + cz * z + dz) / w;
    if (!(w > 0 && depth > -1 && depth < 1)) continue;
    const across = (1 + (ax * x + bx * y + cx * z + dx) / w) * picture.width;
    const down = (1 - (ay * x + by * y + cy * z + dy) / w) * picture.height;
    picture.put(Math.round(0.5 * (across - size)), Math.round(0.5 * (down - size)), size, depth, colours[values[i]!]!);
  }
}

// Draws depths as three bytes.
const depthLook = new THREE.ShaderMaterial({
  glslVersion: THREE.GLSL3,
  vertexShader: /* glsl */ `
    void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`,
  fragmentShader: /* glsl */ `
    layout(location = 0) out vec4 bytes;
    void main() {
      uint depth = uint(gl_FragCoord.z * 16777214.0);
      bytes = vec4(uvec4(depth >> 16, depth >> 8 & 255u, depth & 255u, 255u)) / 255.0;
    }`,
});

// fine: every pixel; coarse: a quarter of them, for things that move in every picture: drawing and reading back cost a quarter.
export type Grain = 'fine' | 'coarse';

const isTransparent = (object: THREE.Object3D): boolean => 'material' in object && (object.material as THREE.Material).transparent;
const isOpaque = (object: THREE.Object3D): boolean => 'material' in object && !(object.material as THREE.Material).transparent;

// Everything besides the points, drawn by WebGL when it or the camera has moved, and read back.
class Ground {
  readonly picture: Picture;
  private readonly target: THREE.WebGLRenderTarget;
  private readonly bytes: Uint8Array<ArrayBuffer>;
  private isFlat = true; // all depths are the farthest

  constructor(width: number, height: number) {
    this.picture = new Picture(width, height);
    this.target = new THREE.WebGLRenderTarget(width, height);
    this.bytes = new Uint8Array(4 * width * height);
  }

  dispose(): void {
    this.target.dispose();
  }

  draw(renderer: THREE.WebGLRenderer, world: THREE.Scene, camera: THREE.Camera, grain: Grain): void {
    const { pixels, depths } = this.picture;
    const clear: THREE.Object3D[] = []; // transparent objects
    let hidesAny = false;
    world.traverseVisible((object) => {
      if (isTransparent(object)) clear.push(object);
      hidesAny ||= isOpaque(object);
    });
    this.read(renderer, world, camera, grain, (pixel, word) => (pixels[pixel] = (0xff000000 | word) >>> 0));
    if (!hidesAny) {
      if (!this.isFlat) depths.fill(farthest);
      this.isFlat = true;
      return;
    }
    this.isFlat = false;
    for (const object of clear) object.visible = false;
    world.overrideMaterial = depthLook;
    renderer.setClearColor(0xffffff);
    this.read(renderer, world, camera, grain, (pixel, word) => {
      const depth = ((word & 255) << 16) | (word & 0xff00) | ((word >> 16) & 255);
      depths[pixel] = depth === 0xffffff ? farthest : (2 * depth) / 16777214 - 1;
    });
    world.overrideMaterial = null;
    for (const object of clear) object.visible = true;
  }

  // WebGL's rows are from the bottom up.
  private read(renderer: THREE.WebGLRenderer, world: THREE.Scene, camera: THREE.Camera, grain: Grain, take: (pixel: number, word: number) => void): void {
    const { width, height } = this.picture;
    const shift = grain === 'coarse' ? 1 : 0;
    const across = (width + shift) >> shift;
    const down = (height + shift) >> shift;
    this.target.setSize(across, down);
    renderer.setRenderTarget(this.target);
    renderer.render(world, camera);
    renderer.readRenderTargetPixels(this.target, 0, 0, across, down, this.bytes);
    renderer.setRenderTarget(null);
    const words = new Uint32Array(this.bytes.buffer);
    for (let y = 0; y < height; ++y) {
      const row = (y >> shift) * across;
      const to = (height - 1 - y) * width;
      for (let x = 0; x < width; ++x) take(to + x, words[row + (x >> shift)]!);
    }
  }
}

// The points of a scene in which nothing else moves, and their surroundings, in a picture that the page shows as it is.
export class DottedPicture {
  private readonly context: CanvasRenderingContext2D;
  private image = new ImageData(1, 1);
  private picture = new Picture(1, 1);
  private ground = new Ground(1, 1);
  private groundSeen = ''; // the view from which it was drawn

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly size: number, // of a point, pixels
    private readonly paper: THREE.Color,
  ) {
    this.context = canvas.getContext('2d', { alpha: false })!;
  }

  resize(width: number, height: number): void {
    this.canvas.width = width;
    this.canvas.height = height;
    this.picture = new Picture(width, height);
    this.image = new ImageData(new Uint8ClampedArray(this.picture.pixels.buffer), width, height);
    this.ground.dispose();
    this.ground = new Ground(width, height);
    this.groundSeen = '';
  }

  // Call it when the world has changed, not only the camera.
  forgetGround(): void {
    this.groundSeen = '';
  }

  draw(renderer: THREE.WebGLRenderer, world: THREE.Scene, camera: THREE.Camera, grain: Grain, shown: Shown | undefined, colours: Uint32Array): void {
    const seen = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements;
    const from = seen.join();
    if (from !== this.groundSeen) {
      renderer.setClearColor(this.paper);
      this.ground.draw(renderer, world, camera, grain);
      this.groundSeen = from;
    }
    this.picture.begin(this.ground.picture);
    if (shown) drawDots(this.picture, this.size, seen, shown, colours);
    this.context.putImageData(this.image, 0, 0);
  }
}
