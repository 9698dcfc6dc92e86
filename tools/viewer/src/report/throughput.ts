// How long a step of a particle takes by how many there are, with the sizes of the caches.
import { axis, inks, lines } from './chart';
import type { Option } from './chart';
import { curvesOption } from './curves';
import type { Machine, Throughput } from './data';
import { bytesText, text } from './format';
import { stylesOf } from './style';

export const nameOfThroughput = (each: Throughput): string =>
  `${each.precision}, ${each.steps_per_call} step${each.steps_per_call === 1 ? '' : 's'} a call`;

// Bands of the state's bytes that a level of cache holds but the one before does not.
function bands(machine: Machine): Record<string, unknown> {
  const { soft, line } = inks();
  let before = 1;
  const data = (machine.caches ?? []).map(({ level, bytes }, i) => {
    const band = [
      { name: `L${level}, ${bytesText(bytes)}`, xAxis: before, itemStyle: { color: line, opacity: i % 2 === 0 ? 0.45 : 0.2 } },
      { xAxis: bytes },
    ];
    before = bytes;
    return band;
  });
  return { markArea: { silent: true, data, label: { color: soft, position: 'insideTop' } } };
}

export function throughputOption(all: readonly Throughput[], machine: Machine): Option {
  const styles = stylesOf(all.map(nameOfThroughput));
  const curves = all.map((each) => ({
    name: nameOfThroughput(each),
    style: styles.get(nameOfThroughput(each))!,
    hasMarks: true,
    points: each.sizes.map(({ particles, bytes, ns_per_particle_step: y }) => ({
      x: bytes,
      y,
      told: lines(nameOfThroughput(each), [
        ['particles', text(particles)],
        ['their state', bytesText(bytes)],
        ['a step', `${text(y)} ns per particle`],
        ['throughput', `${text(1e9 / y)} particle-steps/s`],
      ]),
    })),
  }));
  const smallest = Math.min(...all.flatMap(({ sizes }) => sizes.map(({ bytes }) => bytes)));
  const frame = {
    x: axis('bytes of the particles', 30, { kind: 'log', low: smallest / 2, marks: bytesText }),
    y: axis('ns per particle and step', 46, { kind: 'log' }),
  };
  return curvesOption(frame, curves, bands(machine));
}
