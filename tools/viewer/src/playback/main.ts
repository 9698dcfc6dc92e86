// The page that plays what `dvdx run --out scene.html` wrote.
import './playback.css';
import { unpacked } from '../shared/bytes';
import { dataElements, element } from '../shared/page';
import { isDark } from '../shared/palette';
import { Controls } from './controls';
import { type Frame, FrameDecoder, type FrameFacts, frameFacts } from './frames';
import { Player } from './player';
import { readBounds, readJoints, readScene } from './scene';
import { type Inks, View, hasWebGl } from './view';

// The page's present state, for scripts that drive it from outside.
interface Shown {
  frames: number;
  loaded: number;
  frame: number;
  step: number;
  time: number; // s
  count: number;
  drawn: number; // pictures so far
  seen: number[]; // the matrix from positions to clip space
  isPlaying: boolean;
  positions: Float32Array; // of the frame, m
}

declare global {
  interface Window {
    dvdx?: () => Shown;
  }
}

function inks(): Inks {
  const ground = getComputedStyle(document.documentElement).getPropertyValue('--ground');
  return isDark() ? { plain: [0.79, 0.82, 0.87], line: 0x8d97a5, ground } : { plain: [0.2, 0.31, 0.42], line: 0x66707d, ground };
}

function countText(frame: FrameFacts): string {
  const number = new Intl.NumberFormat('en').format;
  const text = `${number(frame.all)} particle${frame.all === 1 ? '' : 's'}`;
  const bad = frame.bad > 0 ? `, ${number(frame.bad)} not finite` : '';
  return (frame.count === frame.all ? text : `${text}, ${number(frame.count)} of them shown`) + bad;
}

// Returns a speed that nine frames in ten do not exceed: a jolt must not leave the other frames without colour.
function usualSpeed(facts: readonly FrameFacts[]): number {
  const speeds = facts.map(({ speed }) => speed).sort((a, b) => a - b);
  return speeds[Math.floor(0.9 * (speeds.length - 1))]!;
}

const toldEvery = 60; // ms, while it plays: text that changes with every picture cannot be read, and costs as much as one

function say(text: string): void {
  element('message', HTMLParagraphElement).textContent = text;
}

// Loads frames one after another, each from the ones before. The page stays alive meanwhile.
class Frames {
  readonly all: Frame[] = [];
  readonly facts: FrameFacts[];
  private readonly decoder = new FrameDecoder();

  constructor(private readonly elements: HTMLScriptElement[]) {
    this.facts = elements.map(({ dataset }) => frameFacts(dataset));
  }

  async load(loaded: (count: number) => void): Promise<void> {
    for (const [i, source] of this.elements.entries()) {
      const bytes = await unpacked(source.textContent ?? '');
      source.remove();
      this.all.push(this.decoder.decode(bytes, this.facts[i]!));
      loaded(i + 1);
    }
  }
}

async function start(): Promise<void> {
  const scene = readScene();
  const bounds = readBounds();
  const name = scene.name ?? 'dvdx';
  document.title = `${name} – dvdx`;
  element('name', HTMLHeadingElement).textContent = name;
  element('about', HTMLParagraphElement).textContent = scene.about ?? '';
  const frames = new Frames(dataElements('frame'));
  const first = frames.facts[0];
  if (!first) throw new Error('this file holds no state: it is not whole');
  element('count', HTMLSpanElement).textContent = countText(first);
  if (!hasWebGl()) {
    say(
      'This browser offers no WebGL 2, which the picture is drawn with.\n' +
        'Turn on hardware acceleration in its settings, or open the file in another browser; ' +
        'or write the states for ParaView (--out scene.vtp) or Blender (--out scene.pc2).',
    );
    return;
  }

  const player = new Player(frames.facts.map(({ time }) => time));
  let onFirst = (): void => {};
  const hasFirst = new Promise<void>((resolve) => (onFirst = resolve));
  const loading = element('loading', HTMLSpanElement);
  const whole = frames.load((count) => {
    player.loadedFrames = count;
    const isAll = count === frames.facts.length;
    loading.textContent = isAll ? '' : `Loading ${Math.floor((100 * count) / frames.facts.length)} %`;
    onFirst();
  });
  await Promise.race([hasFirst, whole]);

  const canvas = element('picture', HTMLCanvasElement);
  const view = new View(canvas, scene, bounds, await readJoints(scene, frames.all[0]!), frames.all[0]!, frames.facts, inks(), {
    above: [element('top', HTMLDivElement)],
    below: [document.querySelector('footer')!],
  });
  view.highestSpeed = usualSpeed(frames.facts);
  const controls = new Controls(player, view, scene, bounds, frames.all);
  say('');
  player.isPlaying = player.span > 0 && !matchMedia('(prefers-reduced-motion: reduce)').matches;

  let drawn = 0;
  let before = performance.now();
  let shown = -1;
  let told = -Infinity;
  const tick = (now: number): void => {
    player.advance(Math.min(0.25, (now - before) / 1000));
    before = now;
    const { index, blend } = player.place();
    const frame = frames.all[index]!;
    view.show(frame, index, blend, player.time());
    if (view.draw()) ++drawn;
    if (!player.isPlaying || now - told > toldEvery) {
      controls.update();
      told = now;
    }
    if (shown !== index) element('count', HTMLSpanElement).textContent = countText(frame);
    shown = index;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);

  window.dvdx = () => {
    const { index } = player.place();
    const { step, count, positions } = frames.all[index]!;
    return {
      frames: frames.facts.length,
      loaded: player.loadedFrames,
      frame: index,
      step,
      time: player.time(),
      count,
      drawn,
      seen: view.seen(),
      isPlaying: player.isPlaying,
      positions,
    };
  };
  await whole;
}

start().catch((reason: unknown) => {
  say(`This page cannot show its scene: ${reason instanceof Error ? reason.message : String(reason)}`);
  console.error(reason);
});
