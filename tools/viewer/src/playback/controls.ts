// Buttons, sliders and keys.
import { element } from '../shared/page';
import { cssGradient, rising } from '../shared/palette';
import type { Frame } from './frames';
import type { Player } from './player';
import type { Bounds, Scene } from './scene';
import { type Colouring, errorOctaves } from './tints';
import type { Part, View } from './view';

const speeds = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10] as const;
const turn = Math.PI / 36;

const keys: readonly [string, string][] = [
  ['Space', 'play, pause'],
  ['← →', 'a frame back, on'],
  ['Home End', 'start, end'],
  ['+ −', 'faster, slower'],
  ['W A S D', 'turn'],
  ['Q E', 'nearer, farther'],
  ['R', 'look as at first'],
  ['C', 'colour'],
  ['P L M F N O', 'points, springs, mesh, faces, pins, surroundings'],
];

const partNames: readonly [Part, string, string][] = [
  ['points', 'points', 'p'],
  ['springs', 'springs', 'l'],
  ['sides', 'mesh', 'm'],
  ['faces', 'faces', 'f'],
  ['pins', 'pins', 'n'],
  ['contacts', 'surroundings', 'o'],
];

export const shortNumber = (value: number): string =>
  value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e5) ? value.toExponential(2) : String(Number(value.toPrecision(3)));

export class Controls {
  private readonly play = element('play', HTMLButtonElement);
  private readonly scrub = element('scrub', HTMLInputElement);
  private readonly time = element('time', HTMLOutputElement);
  private readonly speed = element('speed', HTMLSelectElement);
  private readonly colouring = element('colouring', HTMLSelectElement);
  private readonly boxes = new Map<Part, HTMLInputElement>();
  private readonly decimals: number;

  constructor(
    private readonly player: Player,
    private readonly view: View,
    private readonly scene: Scene,
    private readonly bounds: Bounds,
    private readonly loaded: readonly Frame[], // so far
  ) {
    const hasErrors = bounds.error > 0;
    this.decimals = Math.max(2, Math.min(6, 2 - Math.floor(Math.log10(player.span || 1))));
    this.scrub.max = String(player.span);
    this.scrub.step = player.span > 0 ? String(player.span / 1e5) : 'any';
    this.scrub.disabled = player.span === 0;
    this.play.disabled = player.span === 0;
    this.play.addEventListener('click', () => this.togglePlaying());
    this.scrub.addEventListener('input', () => {
      player.isPlaying = false;
      player.seek(Number(this.scrub.value));
    });
    for (const speed of speeds) this.speed.add(new Option(`${speed} ×`, String(speed), speed === 1, speed === 1));
    this.speed.addEventListener('change', () => (player.speed = Number(this.speed.value)));
    const colourings: [Colouring, string][] = [['speed', 'by speed'], ['plain', 'plain']];
    if (view.stretch.isKnown) colourings.splice(1, 0, ['stretch', 'by stretch']);
    if (hasErrors) colourings.splice(1, 0, ['error', 'by error']);
    for (const [value, text] of colourings) this.colouring.add(new Option(text, value));
    this.colouring.addEventListener('change', () => this.colour(this.colouring.value as Colouring));
    if (hasErrors) this.colouring.value = 'error';
    this.colour(this.colouring.value as Colouring);
    this.addBoxes();
    element('help', HTMLParagraphElement).append(...keys.map(([key, what]) => helpItem(key, what)));
    document.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.target instanceof HTMLSelectElement) return;
      const isPressedBySpace = event.target instanceof HTMLButtonElement || (event.target instanceof HTMLInputElement && event.target.type === 'checkbox');
      if (event.key === ' ' && isPressedBySpace) return;
      if (this.pressed(event.key)) event.preventDefault();
    });
  }

  update(): void {
    const { player } = this;
    const now = `${player.time().toFixed(this.decimals)} of ${shortNumber(player.end)} s`;
    if (this.play.dataset['state'] !== String(player.isPlaying)) {
      this.play.dataset['state'] = String(player.isPlaying);
      this.play.textContent = player.isPlaying ? '❚❚' : '▶';
      this.play.setAttribute('aria-label', player.isPlaying ? 'Pause' : 'Play');
    }
    this.scrub.value = String(player.elapsed);
    this.scrub.setAttribute('aria-valuetext', now);
    this.time.value = now;
  }

  private togglePlaying(): void {
    const { player } = this;
    if (!player.isPlaying && player.elapsed >= player.span) player.seek(0);
    player.isPlaying = !player.isPlaying && player.span > 0;
  }

  private changeSpeed(by: number): void {
    const index = this.speed.selectedIndex + by;
    if (index < 0 || index >= speeds.length) return;
    this.speed.selectedIndex = index;
    this.player.speed = speeds[index]!;
  }

  private nextColouring(): void {
    this.colouring.selectedIndex = (this.colouring.selectedIndex + 1) % this.colouring.length;
    this.colour(this.colouring.value as Colouring);
  }

  private toggle(part: Part): void {
    this.view.toggle(part);
    const box = this.boxes.get(part);
    if (box) box.checked = this.view.isVisible(part);
  }

  private addBoxes(): void {
    const holder = element('parts', HTMLSpanElement);
    for (const [part, name] of partNames) {
      if (!this.view.has(part)) continue;
      const box = document.createElement('input');
      box.type = 'checkbox';
      box.checked = this.view.isVisible(part);
      box.addEventListener('change', () => this.toggle(part));
      const label = document.createElement('label');
      label.append(box, name);
      holder.append(label);
      this.boxes.set(part, box);
    }
  }

  private colour(colouring: Colouring): void {
    this.view.colouring = colouring;
    if (colouring === 'stretch' && this.view.stretch.highest === 0) this.view.stretch.scale(this.loaded);
    const legend = element('legend', HTMLElement);
    legend.hidden = colouring === 'plain';
    element('legend-bar', HTMLDivElement).style.background = cssGradient(rising);
    const { title, low, high } = this.legendOf(colouring);
    element('legend-title', HTMLDivElement).textContent = title;
    element('legend-low', HTMLSpanElement).textContent = low;
    element('legend-high', HTMLSpanElement).textContent = high;
  }

  private legendOf(colouring: Colouring): { title: string; low: string; high: string } {
    const { bounds, view } = this;
    if (colouring === 'error') {
      const low = `${shortNumber(bounds.error * 2 ** -errorOctaves)} m`;
      return { title: `Distance from ${this.scene.reference ?? 'the reference'}`, low, high: `${shortNumber(bounds.error)} m` };
    }
    if (colouring === 'stretch') return { title: 'Stretch', low: '0 %', high: `≥ ${shortNumber(100 * view.stretch.highest)} %` };
    return { title: 'Speed', low: '0 m/s', high: `${view.highestSpeed < bounds.speed ? '≥ ' : ''}${shortNumber(view.highestSpeed)} m/s` };
  }

  // Acts on a key. Returns whether the key has an action.
  private pressed(key: string): boolean {
    const { player, view } = this;
    const actions: Record<string, () => void> = {
      ' ': () => this.togglePlaying(),
      ArrowLeft: () => player.stepFrames(-1),
      ArrowRight: () => player.stepFrames(1),
      Home: () => player.seek(0),
      End: () => player.seek(player.span),
      '+': () => this.changeSpeed(1),
      '=': () => this.changeSpeed(1),
      '-': () => this.changeSpeed(-1),
      w: () => view.turn(0, turn),
      s: () => view.turn(0, -turn),
      a: () => view.turn(-turn, 0),
      d: () => view.turn(turn, 0),
      q: () => view.zoom(1 / 1.1),
      e: () => view.zoom(1.1),
      r: () => view.lookFromStart(),
      c: () => this.nextColouring(),
    };
    for (const [part, , letter] of partNames) actions[letter] = () => this.toggle(part);
    const action = actions[key.length === 1 ? key.toLowerCase() : key];
    action?.();
    return action !== undefined;
  }
}

function helpItem(key: string, what: string): HTMLElement {
  const item = document.createElement('span');
  for (const each of key.split(' ')) {
    const cap = document.createElement('kbd');
    cap.textContent = each;
    item.append(cap, ' ');
  }
  item.append(what);
  return item;
}
