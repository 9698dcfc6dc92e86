// The cost of a step over the number of particles, with the caches that their state fits into.
import { distinct } from '../shared/palette';
import { type Option, axis, inks, lines } from './chart';
import { type Curve, curvesOption } from './curves';
import type { Cache, Machine, Throughput } from './data';
import { power, text } from './format';
import { make, number, table, words } from './html';
import { type Style, key } from './style';

export interface Band {
  name: string;
  from: number; // particles
  to: number;
}

// Returns the bytes of all caches of a level that the threads have among them.
const reached = ({ bytes, processors }: Cache, threads: number): number => bytes * Math.ceil(threads / processors);

// Returns bands of the particle numbers whose state fits into a cache, the nearest cache first, then memory.
export function bandsOf(machine: Machine, bytesPerParticle: number, fewest: number, most: number): Band[] {
  const levels = [...machine.caches].sort((a, b) => a.level - b.level);
  const ends = levels.map((cache) => ({ name: `L${cache.level}`, end: reached(cache, machine.threads) / bytesPerParticle }));
  let from = fewest;
  const bands: Band[] = [];
  for (const { name, end } of [...ends, { name: ends.length > 0 ? 'memory' : '', end: most }]) {
    const to = Math.min(end, most);
    if (name !== '' && to > from) bands.push({ name, from, to });
    from = Math.max(from, to);
  }
  return bands;
}

const callText = (steps: number): string => (steps === 1 ? 'one step a call' : `${steps} steps a call`);

function stylesOf(all: readonly Throughput[]): (one: Throughput) => Style {
  const calls = [...new Set(all.map(({ steps_per_call: steps }) => steps))];
  const precisions = [...new Set(all.map(({ precision }) => precision))];
  return ({ steps_per_call: steps, precision }) => {
    const i = calls.indexOf(steps);
    return { colour: distinct[i % distinct.length]!, mark: i === 0 ? 'circle' : 'rect', isDashed: precision !== precisions[0] };
  };
}

const curveName = (one: Throughput): string => `${one.precision}, ${callText(one.steps_per_call)}`;

function told(one: Throughput): string {
  return lines(curveName(one), [
    ['particles', text(one.particles, 7)],
    ['of a step', `${text(one.ns_per_particle_step)} ns per particle`],
    ['particle-steps', `${text(1e9 / one.ns_per_particle_step)} a second`],
    ['state', `${text(one.state_bytes / 1024)} KiB`],
  ]);
}

export function throughputOption(machine: Machine, all: readonly Throughput[], precisions: ReadonlySet<string>): Option {
  const shown = all.filter(({ precision }) => precisions.has(precision));
  const styleOf = stylesOf(all);
  const curves: Curve[] = [...new Set(shown.map(curveName))].map((name) => {
    const own = shown.filter((one) => curveName(one) === name);
    return { name, style: styleOf(own[0]!), hasMarks: true, points: own.map((one) => ({ x: one.particles, y: one.ns_per_particle_step, told: told(one) })) };
  });
  const sizes = shown.map(({ particles }) => particles);
  const [low, high] = [Math.min(...sizes) / 1.5, Math.max(...sizes) * 1.5];
  const frame = { x: axis('particles', 30, { kind: 'log', low, high, marks: (value) => (Number.isInteger(Math.log10(value)) ? power(value) : '') }), y: axis('ns per particle and step', 46, { kind: 'log' }) };
  const option = curvesOption(frame, curves);
  const [first] = shown;
  const bands = first ? bandsOf(machine, first.state_bytes / first.particles, low, high) : [];
  return { ...option, series: [...(option.series as object[]), bandSeries(bands)] } as Option;
}

function bandSeries(bands: readonly Band[]): object {
  const { soft, line } = inks();
  const data = bands.map(({ name, from, to }, i) => [
    { name, xAxis: from, itemStyle: { color: line, opacity: i % 2 === 0 ? 0.55 : 0.15 } },
    { xAxis: to },
  ]);
  return { type: 'line', data: [], silent: true, markArea: { silent: true, data, label: { position: 'insideTop', color: soft, fontSize: 12 } } };
}

export function throughputKeys(all: readonly Throughput[]): HTMLElement {
  const styleOf = stylesOf(all);
  const each = new Map(all.map((one) => [curveName(one), styleOf(one)]));
  return make('p', { class: 'keys' }, ...[...each].flatMap(([name, style]) => [make('span', {}, key(style), ` ${name}`), ' ']));
}

export function throughputTable(all: readonly Throughput[]): HTMLElement {
  const rows = all.map((one) => ({
    cells: [
      words(one.precision), number(one.particles, '', 9), number(one.state_bytes, '', 9), number(one.steps_per_call),
      number(one.ns_per_particle_step), number(1e9 / one.ns_per_particle_step),
    ],
  }));
  return make('details', { class: 'runs' }, make('summary', {}, `Throughput at ${all.length} sizes and calls`),
    table(['precision', 'particles', 'bytes of state', 'steps a call', 'ns per particle-step', 'particle-steps a second'], rows));
}
