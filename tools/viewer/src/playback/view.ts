// The picture: camera, particles, their joints and the bodies that they meet.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { Colour } from '../shared/palette';
import { AnchoredSprings, anchorsBox } from './anchored';
import { Balls, largestOf } from './balls';
import { DottedPicture, type Grain, type Shown, packed } from './dots';
import type { Frame, FrameFacts } from './frames';
import { type Look, lift, makeLook } from './materials';
import { type Framing, aroundNearlyAll, boxOf, framingOf, placeFor, withBodies } from './framing';
import { Ropes } from './ropes';
import type { Bounds, Joints, Pieces, Scene } from './scene';
import { Stretch } from './stretch';
import { Surroundings } from './surroundings';
import { type Colouring, type Highest, colourTable, fillTints } from './tints';

export type Part = 'points' | 'springs' | 'sides' | 'faces' | 'pins' | 'contacts';

// Texts and controls that lie on the picture.
export interface Covers {
  above: readonly HTMLElement[];
  below: readonly HTMLElement[];
}

export interface Inks {
  plain: Colour;
  line: THREE.ColorRepresentation;
  ground: string; // the page's, which the picture covers
}

export const hasWebGl = (): boolean => document.createElement('canvas').getContext('webgl2') !== null;

// Whether the processor draws: every pixel that is blended or smoothed then costs time.
function isSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const facts = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = facts ? String(gl?.getParameter(facts.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

const shown = 0.94; // part of the free area that the box of everything takes

const largestDots = 2.5; // pixels: below this a ball looks like a square

// The area of the canvas that nothing covers, in pixels; all of it if that is too small to show anything.
interface Area {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

function freeArea(canvas: HTMLElement, { above, below }: Covers): Area {
  const { clientWidth: right, clientHeight: height } = canvas;
  const boxes = (elements: readonly HTMLElement[]): DOMRect[] => elements.map((each) => each.getBoundingClientRect()).filter((box) => box.height > 0);
  const top = Math.max(0, ...boxes(above).map((box) => box.bottom));
  const bottom = Math.min(height, ...boxes(below).map((box) => box.top));
  return bottom - top < 0.25 * height ? { left: 0, top: 0, right, bottom: height } : { left: 0, top, right, bottom };
}

export class View {
  colouring: Colouring = 'speed';
  highestSpeed: number; // at the palette's end, m/s
  private readonly renderer: THREE.WebGLRenderer;
  private readonly world = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
  private readonly controls: OrbitControls;
  private readonly look: Look;
  private readonly position: THREE.BufferAttribute;
  private readonly next: THREE.BufferAttribute;
  private readonly tint: THREE.BufferAttribute;
  readonly stretch: Stretch;
  private ropes: Ropes | undefined;
  private balls: Balls | undefined;
  private hasCorners = false; // something is drawn from position, next and tint
  private readonly parts: Partial<Record<Part, THREE.Object3D>> = {};
  private readonly anchored: AnchoredSprings | undefined;
  private readonly surroundings: Surroundings | undefined;
  private readonly dotted: DottedPicture | undefined; // in place of WebGL's: the processor draws, and only points move
  private dotColours = new Uint32Array(256);
  private readonly size: number; // m
  private readonly framing: Framing;
  private readonly center: THREE.Vector3; // of what is shown at the moment
  private isTouched = false; // the user has moved the camera
  private readonly up: THREE.Vector3;
  private shown: Shown | undefined;
  private onward: Float32Array | undefined; // of the frame that is shown
  private readonly tears: ((frame: number) => void)[] = []; // remove the pieces that are torn in a frame
  private isStale = true;
  private readonly reach: number; // m: how far apart any particles come, at most
  private grain: Grain = 'fine'; // of the surroundings behind dots

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly scene: Scene,
    private readonly bounds: Bounds,
    joints: Joints,
    first: Frame,
    facts: readonly FrameFacts[],
    private readonly inks: Inks,
    private readonly covers: Covers,
  ) {
    const capacity = Math.max(1, ...facts.map(({ count }) => count));
    this.highestSpeed = bounds.speed;
    const isPlain = isSoftware();
    const pointSize = Math.min(14, Math.max(2, 16 * capacity ** -0.19));
    THREE.ColorManagement.enabled = false; // all colours are the screen's
    const paper = new THREE.Color(inks.ground);
    const arePointsAlone = scene.radii === undefined && joints.lines.corners.length === 0 && joints.triangles.corners.length === 0 && !scene.anchors?.length && !scene.pins?.length;
    if (isPlain && arePointsAlone && pointSize < largestDots) this.dotted = new DottedPicture(canvas, Math.round(pointSize), paper);
    this.renderer = new THREE.WebGLRenderer({ ...(this.dotted ? {} : { canvas }), antialias: !isPlain, alpha: false });
    this.renderer.setClearColor(paper);
    this.renderer.setPixelRatio(isPlain ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.up = this.upward();
    this.stretch = new Stretch([joints.lines, joints.sides], joints.restOf);
    const anchors = anchorsBox(scene.anchors ?? [], first);
    const largest = largestOf(scene.radii ?? 0);
    const boxes = facts.map(({ box }) => (box ? boxOf(box).expandByScalar(largest).union(anchors) : boxOf(undefined)));
    const most = aroundNearlyAll(boxes);
    const middle = most.isEmpty() ? new THREE.Vector3() : most.getCenter(new THREE.Vector3());
    const least = Math.max(1e-6 * middle.length(), 1e-9);
    const widest = most.isEmpty() ? 0 : most.min.distanceTo(most.max);

    this.look = makeLook(pointSize, inks.line);
    const attribute = (array: Float32Array | Uint8Array, items: number): THREE.BufferAttribute =>
      new THREE.BufferAttribute(array, items, array instanceof Uint8Array).setUsage(THREE.DynamicDrawUsage);
    this.position = attribute(new Float32Array(3 * capacity), 3);
    this.next = attribute(new Float32Array(3 * capacity), 3);
    this.tint = attribute(new Uint8Array(4 * capacity), 4);
    this.addParticles(joints, capacity);
    const springs = scene.anchors ?? [];
    if (springs.length > 0) {
      this.anchored = new AnchoredSprings(springs, first, inks.line);
      this.add('springs', this.anchored.object);
    }
    if (scene.contacts?.length) {
      const drawn = isPlain ? 'grids' : 'grids and sheets';
      const floor = { center: middle, size: 1.4 * Math.max(widest, least), ink: inks.line, drawn } as const;
      this.surroundings = new Surroundings(scene.contacts, scene.motions ?? [], floor);
      this.add('contacts', this.surroundings.object);
    }
    const times = facts.map(({ time }) => time);
    const around = facts.map(({ time }, i) => withBodies(boxes[i]!, this.surroundings?.bodiesAt(time) ?? [], widest));
    this.framing = framingOf(around, times, this.up.z === 1 ? 'z' : 'y');
    this.center = this.framing.centers[0]!.clone();
    this.size = Math.max(this.framing.extent.length(), least);
    this.reach = new THREE.Vector3(...bounds.low).distanceTo(new THREE.Vector3(...bounds.high));

    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.controls.addEventListener('change', () => (this.isStale = true));
    this.controls.addEventListener('start', () => (this.isTouched = true));
    const observer = new ResizeObserver(() => this.resize());
    for (const each of [canvas, ...covers.above, ...covers.below]) observer.observe(each);
    this.resize();
    this.lookFromStart();
  }

  has(part: Part): boolean {
    return this.parts[part] !== undefined;
  }

  isVisible(part: Part): boolean {
    return this.parts[part]?.visible ?? false;
  }

  toggle(part: Part): void {
    const object = this.parts[part];
    if (object) object.visible = !object.visible;
    this.dotted?.forgetGround();
    this.isStale = true;
  }

  // `blend` of the way from a frame, the index-th, to the next, at a time in s.
  show(now: Frame, index: number, blend: number, time: number): void {
    const { uniforms } = this.look;
    this.moveSurroundings(time);
    this.follow(index, blend);
    const isNew = this.shown?.now !== now || this.shown.colouring !== this.colouring;
    if (this.colouring === 'stretch') now.stretches ??= this.stretch.bytes(now, index);
    const highest: Highest = { speed: this.highestSpeed, error: this.bounds.error };
    if (isNew && this.dotted) this.dotColours = Uint32Array.from(colourTable(now, this.colouring, highest, this.inks.plain), packed);
    if (isNew && this.hasCorners) {
      this.upload(this.position, now.positions);
      fillTints(this.tint.array as Uint8Array, now, this.colouring, highest, this.inks.plain);
      this.mark(this.tint, 4 * now.count);
    }
    const isOnward = this.onward !== now.onward; // or its frame has loaded since
    if (isOnward && this.hasCorners) this.upload(this.next, now.onward);
    if (isNew || isOnward) this.ropes?.move(now, this.tint.array as Uint8Array, index);
    if (isNew || isOnward) this.balls?.move(now, this.tint.array as Uint8Array);
    if (!isNew && !isOnward && uniforms.blend.value === blend) return;
    uniforms.blend.value = blend;
    this.setCount(now.count);
    for (const takeOut of this.tears) takeOut(index);
    this.anchored?.move(now, blend);
    this.shown = { now, blend, colouring: this.colouring };
    this.onward = now.onward;
    this.isStale = true;
  }

  private follow(index: number, blend: number): void {
    const { centers } = this.framing;
    const now = centers[index]!.clone().lerp(centers[Math.min(index + 1, centers.length - 1)]!, blend);
    if (now.equals(this.center)) return;
    const way = now.clone().sub(this.center);
    this.center.copy(now);
    this.controls.target.add(way);
    this.camera.position.add(way);
    this.isStale = true;
  }

  // Returns the matrix from positions to clip space, column after column.
  seen(): number[] {
    return new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse).elements;
  }

  // Moves the surroundings, whose grain is coarse while they move and fine again when they rest.
  private moveSurroundings(time: number): void {
    const grain = this.surroundings?.move(time) ? 'coarse' : 'fine';
    if (grain === 'fine' && this.grain === 'fine') return;
    this.grain = grain;
    this.dotted?.forgetGround();
    this.isStale = true;
  }

  // Draws the picture. Returns false if the picture is as it was, so that nothing was drawn.
  draw(): boolean {
    this.controls.update();
    if (!this.isStale) return false;
    this.isStale = false;
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.look.uniforms.focus.value = distance;
    this.camera.near = Math.max(1e-3 * distance, 1e-9);
    this.camera.far = distance + 20 * this.size + this.reach;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    if (this.dotted) this.dotted.draw(this.renderer, this.world, this.camera, this.grain, this.isVisible('points') ? this.shown : undefined, this.dotColours);
    else this.renderer.render(this.world, this.camera);
    return true;
  }

  lookFromStart(): void {
    const { extent } = this.framing;
    const isFlat = extent.z < 0.05 * this.size && this.up.y === 1;
    const side = this.up.z === 1 ? new THREE.Vector3(0.55, -0.75, 0.35) : new THREE.Vector3(0.5, 0.38, 0.78);
    const direction = isFlat ? new THREE.Vector3(0, 0, 1) : side.normalize();
    this.camera.up.copy(this.up);
    const right = new THREE.Vector3().crossVectors(this.up, direction).normalize();
    const above = new THREE.Vector3().crossVectors(direction, right);
    const { left, top, right: end, bottom } = freeArea(this.canvas, this.covers);
    const half = Math.tan((Math.PI / 360) * this.camera.fov) / this.canvas.clientHeight; // the tangent of a pixel's angle
    const [across, upwards] = [half * (end - left), half * (bottom - top)];
    const place = placeFor(extent, direction, right, above, shown * across, shown * upwards);
    this.controls.target.copy(this.center).addScaledVector(right, place.right).addScaledVector(above, place.above);
    this.camera.position.copy(this.controls.target).addScaledVector(direction, Math.max(place.distance, 0.5 * this.size));
    this.controls.update();
    this.isTouched = false;
    this.isStale = true;
  }

  turn(across: number, upwards: number): void {
    this.isTouched = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.up, -across);
    const axis = new THREE.Vector3().crossVectors(this.up, offset).normalize();
    offset.applyAxisAngle(axis, -upwards);
    if (offset.angleTo(this.up) > 0.05 && offset.angleTo(this.up) < Math.PI - 0.05) {
      this.camera.position.copy(this.controls.target).add(offset);
    }
    this.isStale = true;
  }

  zoom(factor: number): void {
    this.isTouched = true;
    this.camera.position.lerpVectors(this.controls.target, this.camera.position, factor);
    this.isStale = true;
  }

  private upward(): THREE.Vector3 {
    const [x, y, z] = this.scene.gravity ?? [0, 0, 0];
    if (Math.abs(z) > Math.abs(y) && Math.abs(z) >= Math.abs(x)) return new THREE.Vector3(0, 0, 1);
    return new THREE.Vector3(0, 1, 0);
  }

  private addParticles(joints: Joints, capacity: number): void {
    const geometry = (index?: Uint32Array<ArrayBuffer>): THREE.BufferGeometry => {
      this.hasCorners = true;
      const made = new THREE.BufferGeometry();
      made.setAttribute('position', this.position);
      made.setAttribute('next', this.next);
      made.setAttribute('tint', this.tint);
      if (index) made.setIndex(new THREE.BufferAttribute(index, 1));
      return made;
    };
    const pieces = ({ corners, whole }: Pieces, size: number): THREE.BufferGeometry => {
      const made = geometry(corners);
      if (whole) this.tears.push((frame) => made.setDrawRange(0, size * whole(frame)));
      return made;
    };
    const { lines, sides, triangles, covered } = joints;
    const hasFaces = triangles.corners.length > 0;
    if (this.scene.radii !== undefined) {
      this.hasCorners = true;
      this.balls = new Balls(this.scene.radii, capacity, this.look.uniforms.blend);
    }
    const bare = hasFaces ? Uint32Array.from({ length: capacity }, (_, i) => i).filter((i) => !covered.has(i)) : undefined;
    const isBare = bare !== undefined && bare.length > 0;
    const points = (): THREE.Object3D => new THREE.Points(geometry(isBare ? bare : undefined), this.look.points);
    this.add('points', this.dotted ? new THREE.Group() : (this.balls?.object ?? points()));
    if (lines.corners.length > 2 * Ropes.most) {
      this.add('springs', new THREE.LineSegments(pieces(lines, 2), this.look.lines));
    } else if (lines.corners.length > 0) {
      this.ropes = new Ropes(lines, Math.max(1.4, 0.4 * this.look.pointSize) * this.renderer.getPixelRatio(), lift, this.look.uniforms.blend);
      this.add('springs', this.ropes.object);
    }
    if (sides.corners.length > 0) this.add('sides', new THREE.LineSegments(pieces(sides, 2), this.look.lines));
    if (this.scene.pins?.length) this.add('pins', new THREE.Points(geometry(Uint32Array.from(this.scene.pins)), this.look.pins));
    if (!hasFaces) return;
    this.add('faces', new THREE.Mesh(pieces(triangles, 3), this.look.faces));
    if (!isBare && !this.balls) this.toggle('points');
    this.toggle('sides');
  }

  private add(part: Part, object: THREE.Object3D): void {
    object.traverse((each) => (each.frustumCulled = false)); // the particles leave the box that they started in
    const there = this.parts[part];
    if (there) there.add(object);
    else this.world.add((this.parts[part] = object));
  }

  private setCount(count: number): void {
    const points = this.parts.points;
    if (points instanceof THREE.Points && !points.geometry.index) points.geometry.setDrawRange(0, count);
  }

  private upload(attribute: THREE.BufferAttribute, values: Float32Array): void {
    (attribute.array as Float32Array).set(values);
    this.mark(attribute, values.length);
  }

  // Marks the first `count` numbers as new.
  private mark(attribute: THREE.BufferAttribute, count: number): void {
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, count);
    attribute.needsUpdate = true;
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    if (this.dotted) this.dotted.resize(clientWidth, clientHeight);
    else this.renderer.setSize(clientWidth, clientHeight, false);
    this.ropes?.resize(this.canvas.width, this.canvas.height);
    this.camera.aspect = clientWidth / clientHeight;
    // The camera looks at the middle of the free area.
    const { left, top, right, bottom } = freeArea(this.canvas, this.covers);
    this.camera.setViewOffset(clientWidth, clientHeight, 0.5 * (clientWidth - left - right), 0.5 * (clientHeight - top - bottom), clientWidth, clientHeight);
    this.isStale = true;
    if (!this.isTouched) this.lookFromStart();
  }
}
