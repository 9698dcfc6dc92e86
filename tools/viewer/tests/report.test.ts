import { expect, test } from 'vitest';
import { type Cache, type Machine, type Run, type SceneReport, cheapestOf } from '../src/report/data';
import { power, text } from '../src/report/format';
import { colourOf, edgesOf } from '../src/report/stability';
import { bandsOf } from '../src/report/throughput';

test('numbers are short, and their powers readable', () => {
  expect(text(12.345)).toBe('12.3');
  expect(text(1.23e-9)).toBe('1.2·10⁻⁹');
  expect(text(25400)).toBe('25,400');
  expect(text(0)).toBe('0');
  expect(text(null)).toBe('–');
  expect(power(1e-12)).toBe('10⁻¹²');
  expect(power(0.1)).toBe('0.1');
});

const run = (changes: Partial<Run>): Run => ({
  method: 'exact', baseline: false, scheme: null, precision: 'float64', step: 0.5, steps: 2, substeps: 1, isa: '', threads: 1, layout: '', arithmetic: '',
  ns_per_particle_step: 10, seconds_per_simulated_second: 1, error: { position_rms: 1, position_max: 1, velocity_rms: 1, relative: 0.05 }, energy_drift: 0,
  order: null, in_fit: false, diverged: false, ...changes,
});

test('the cheapest run that reaches an error is not always the most exact one', () => {
  const error = { position_rms: 1, position_max: 1, velocity_rms: 1, relative: 1e-5 };
  const runs = [run({}), run({ error, step: 0.1 }), run({ step: 0.05 }), run({ diverged: true, step: 2, substeps: 4 })];
  const [cheapest] = cheapestOf({ runs } as SceneReport);
  expect(cheapest!.runs.map((each) => each?.step)).toEqual([0.5, 0.1, 0.1, 0.1, undefined]);
  expect(cheapest!.best?.step).toBe(0.1);
  expect(cheapest!.divergedSteps).toEqual([0.5]);
});

test('a run that chaos alone places is in no column, and counted', () => {
  const runs = [run({}), run({ ranked: false, step: 0.1, error: { position_rms: 1, position_max: 1, velocity_rms: 1, relative: 0.01 } })];
  const [cheapest] = cheapestOf({ runs } as SceneReport);
  expect(cheapest!.runs.map((each) => each?.step)).toEqual([0.5, undefined, undefined, undefined, undefined]);
  expect(cheapest!.best?.step).toBe(0.5);
  expect(cheapest!.unranked).toBe(1);
});

test('cells of a map meet in the middle, of logarithms where the axis has them', () => {
  expect(edgesOf({ name: '', values: [1, 2, 4], spacing: 'linear' })).toEqual([0.5, 1.5, 3, 5]);
  edgesOf({ name: '', values: [1, 100], spacing: 'logarithmic' }).forEach((edge, i) => expect(edge).toBeCloseTo([0.1, 10, 1000][i]!, 9));
});

test('what grows has other colours than what stays', () => {
  expect(colourOf(1)).toBe(colourOf(1 + 1e-10));
  expect(colourOf(1)).not.toBe(colourOf(1 + 1e-6));
  expect(colourOf(null)).toBe('#3b0f05');
});

test('bands of caches lie side by side, each as wide as its state fits', () => {
  const caches = [
    { level: 1, bytes: 32768, processors: 1 }, { level: 2, bytes: 524288, processors: 1 }, { level: 3, bytes: 2 ** 25, processors: 4 },
  ];
  const machine = { threads: 2, caches } as Machine;
  expect(bandsOf(machine, 32, 256, 2 ** 22)).toEqual([
    { name: 'L1', from: 256, to: 2048 }, { name: 'L2', from: 2048, to: 32768 }, { name: 'L3', from: 32768, to: 2 ** 20 },
    { name: 'memory', from: 2 ** 20, to: 2 ** 22 },
  ]);
  expect(bandsOf(machine, 32, 4096, 8192)).toEqual([{ name: 'L2', from: 4096, to: 8192 }]);
  expect(bandsOf({ threads: 2, caches: [] as Cache[] } as Machine, 32, 256, 1024)).toEqual([]);
});
