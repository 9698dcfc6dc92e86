// Energy over the scene's time, and over a hundred thousand steps.
import { axis, lines } from './chart';
import type { Option } from './chart';
import { curvesOption } from './curves';
import { type LongRun, type SceneReport, isFinite, readableName } from './data';
import { text } from './format';
import type { Style } from './style';

const referenceStyle: Style = { colour: '#7f7f7f', mark: 'circle', isDashed: true };

export function energyOverTime(scene: SceneReport, styles: ReadonlyMap<string, Style>, names: ReadonlySet<string>): Option {
  const [reference] = scene.energy_curves;
  const curves = scene.energy_curves
    .filter((curve) => curve === reference || names.has(curve.method) || !styles.has(curve.method))
    .map((curve) => ({
      name: curve.method,
      style: styles.get(curve.method) ?? referenceStyle,
      hasMarks: curve.times.length < 40 && curve !== reference,
      points: curve.times.flatMap((x, i) => {
        const y = curve.energy[i];
        const told = lines(readableName(curve.method), [['time', `${text(x)} s`], ['energy', `${text(y, 6)} J`]]);
        return isFinite(y) ? [{ x, y, told }] : [];
      }),
    }));
  const [low, high] = range(scene);
  const frame = { x: axis('time, s', 30, { kind: 'value' }), y: axis('energy, J', 48, { kind: 'value', low, high, marks: text }) };
  return curvesOption(frame, curves);
}

// Returns the range of the axis: all of the reference, and as much again (or 1.2 energy scales) of curves that run away.
function range(scene: SceneReport): [number, number] {
  const finite = scene.energy_curves.map(({ energy }) => energy.filter(isFinite));
  const reference = finite[0] ?? [0];
  const middle = (Math.min(...reference) + Math.max(...reference)) / 2;
  const half = Math.max(0.52 * (Math.max(...reference) - Math.min(...reference)), 2e-3 * scene.energy_scale);
  const far = Math.max(2 * half, 1.2 * scene.energy_scale);
  const off = Math.max(half, ...finite.flat().map((each) => 1.05 * Math.abs(each - middle)));
  return [middle - Math.min(off, far), middle + Math.min(off, far)];
}

export function longRunOption(runs: readonly LongRun[], styles: ReadonlyMap<string, Style>, names: ReadonlySet<string>): Option {
  const curves = runs
    .filter(({ method }) => names.has(method))
    .map(({ method, curve }) => ({
      name: method,
      style: styles.get(method) ?? referenceStyle,
      hasMarks: false,
      points: curve.steps.flatMap((x, i) => {
        const y = curve.energy_ratio[i];
        const told = lines(readableName(method), [['steps', text(x)], ['E/E₀', text(y, 5)]]);
        return isFinite(y) && y > 1e-4 ? [{ x, y, told }] : [];
      }),
    }));
  const frame = { x: axis('steps', 30, { kind: 'value', marks: text }), y: axis('E/E₀', 46, { kind: 'log' }) };
  return curvesOption(frame, curves);
}
