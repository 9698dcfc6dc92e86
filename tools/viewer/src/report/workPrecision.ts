// The cost of a simulated second over the distance from the exact motion at its end.
import { axis, lines } from './chart';
import { type Curve, curvesOption } from './curves';
import { type Run, type SceneReport, isFinite, nameOf, nsPerParticleSecond, readableName } from './data';
import type { Option } from './chart';
import { text } from './format';
import type { Style } from './style';

export interface Shown {
  names: ReadonlySet<string>;
  precisions: ReadonlySet<string>;
}

function told(run: Run): string {
  const step = run.substeps === 1 ? `${text(run.step)} s` : `${text(run.step)} s in ${run.substeps} sub-steps`;
  return lines(`${readableName(nameOf(run))}, ${run.precision}`, [
    ['step', step],
    ['error, relative', text(run.error.relative)],
    ['position, rms', `${text(run.error.position_rms)} m`],
    ['cost', `${text(nsPerParticleSecond(run))} ns per particle and simulated second`],
    ['of a step', `${text(run.ns_per_particle_step)} ns per particle`],
    ['energy drift', text(run.energy_drift)],
  ]);
}

function curveOf(scene: SceneReport, name: string, precision: string, style: Style): Curve {
  const points = scene.runs
    .filter((run) => nameOf(run) === name && run.precision === precision && !run.diverged && run.ranked !== false && isFinite(run.error.relative) && run.error.relative > 0)
    .map((run) => ({ x: run.error.relative!, y: nsPerParticleSecond(run), told: told(run) }));
  return { name: `${name} ${precision}`, style, points, hasMarks: true };
}

export function workPrecision(scene: SceneReport, styles: ReadonlyMap<string, Style>, shown: Shown): Option {
  const curves = [...shown.precisions].flatMap((precision) =>
    [...shown.names].map((name) => curveOf(scene, name, precision, styles.get(name)!)),
  );
  const frame = {
    x: axis('error, relative (further right is more exact)', 30, { kind: 'log', isInverse: true }),
    y: axis('ns per particle and simulated second', 46, { kind: 'log' }),
  };
  return curvesOption(frame, curves.filter(({ points }) => points.length > 0));
}
