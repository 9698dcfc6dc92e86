import { expect, test } from 'vitest';
import { type Run, type SceneReport, cheapestOf } from '../src/report/data';
import { power, text } from '../src/report/format';
import { colourOf, edgesOf } from '../src/report/stability';

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

test('cells of a map meet in the middle, of logarithms where the axis has them', () => {
  expect(edgesOf({ name: '', values: [1, 2, 4], spacing: 'linear' })).toEqual([0.5, 1.5, 3, 5]);
  edgesOf({ name: '', values: [1, 100], spacing: 'logarithmic' }).forEach((edge, i) => expect(edge).toBeCloseTo([0.1, 10, 1000][i]!, 9));
});

test('what grows has other colours than what stays', () => {
  expect(colourOf(1)).toBe(colourOf(1 + 1e-10));
  expect(colourOf(1)).not.toBe(colourOf(1 + 1e-6));
  expect(colourOf(null)).toBe('#3b0f05');
});
