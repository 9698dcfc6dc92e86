// The stability maps: growth per step over two quantities, one map per method.
import type { CustomSeriesRenderItemAPI, CustomSeriesRenderItemParams } from 'echarts/types/dist/shared';
import { Chart, type Option, axis, lines, tooltip } from './chart';
import { type GrowthMap, type MapAxis, type Stability, isFinite, readableName } from './data';
import { text } from './format';
import { choice, make, number, table, words } from './html';

const stableWithin = 1e-9; // a growth of one within this is stable

// Returns the edges of cells, midway between the values of neighbouring cells.
export function edgesOf({ values, spacing }: MapAxis): number[] {
  const isLog = spacing === 'logarithmic';
  const at = values.map((value) => (isLog ? Math.log(value) : value));
  const half = (i: number): number => (at[i + 1]! - at[i]!) / 2;
  if (at.length === 1) return isLog ? [values[0]! / 1.1, values[0]! * 1.1] : [values[0]! - 0.5, values[0]! + 0.5];
  const between = at.slice(0, -1).map((value, i) => value + half(i));
  const all = [at[0]! - half(0), ...between, at.at(-1)! + half(at.length - 2)];
  return isLog ? all.map(Math.exp) : all;
}

// Returns blue if the motion dies away or stays, orange to dark if it grows. The colours differ in lightness too.
export function colourOf(growth: number | null): string {
  if (!isFinite(growth)) return '#3b0f05';
  if (growth <= 1 + stableWithin) {
    const left = Math.max(0, Math.min(1, (1 - growth) / 0.6));
    return mixed([223, 236, 246], [62, 124, 177], left);
  }
  const grown = Math.max(0, Math.min(1, (Math.log10(growth - 1) + 4) / 5));
  return grown < 0.5 ? mixed([253, 224, 178], [224, 112, 32], 2 * grown) : mixed([224, 112, 32], [96, 28, 8], 2 * grown - 1);
}

const mixed = (from: readonly number[], to: readonly number[], part: number): string =>
  `rgb(${from.map((each, i) => Math.round(each + part * (to[i]! - each))).join(',')})`;

function verdict(growth: number | null): string {
  if (!isFinite(growth)) return 'not finite';
  if (growth > 1 + stableWithin) return `grows, × ${text(growth, 5)} a step`;
  return growth < 1 - stableWithin ? `dies away, × ${text(growth, 5)} a step` : 'stays';
}

export function mapOption(map: GrowthMap): Option {
  const xs = edgesOf(map.x);
  const ys = edgesOf(map.y);
  const width = map.x.values.length;
  const renderItem = (_: CustomSeriesRenderItemParams, api: CustomSeriesRenderItemAPI) => {
    const cell = api.value(0) as number;
    const i = cell % width;
    const k = Math.floor(cell / width);
    const [left, bottom] = api.coord([xs[i]!, ys[k]!]) as [number, number];
    const [right, top] = api.coord([xs[i + 1]!, ys[k + 1]!]) as [number, number];
    const shape = { x: left, y: top, width: right - left + 0.5, height: bottom - top + 0.5 };
    return { type: 'rect' as const, shape, style: { fill: colourOf(map.measured[cell] ?? null) } };
  };
  const formatter = (at: unknown): string => {
    const { dataIndex, seriesIndex } = at as { dataIndex: number; seriesIndex: number };
    if (seriesIndex !== 0) return '';
    const x = map.x.values[dataIndex % width];
    const y = map.y.values[Math.floor(dataIndex / width)];
    return lines(readableName(map.method), [
      [map.x.name, text(x, 4)],
      [map.y.name, text(y, 4)],
      ['measured', verdict(map.measured[dataIndex] ?? null)],
      ['by analysis', verdict(map.analysed[dataIndex] ?? null)],
    ]);
  };
  const scale = ({ name, spacing }: MapAxis, ends: number[], gap: number): Record<string, unknown> => ({
    ...axis(name, gap, { kind: spacing === 'logarithmic' ? 'log' : 'value', low: ends[0]!, high: ends.at(-1)!, marks: (v) => text(v, 2) }),
    splitLine: { show: false },
  });
  const limits = map.limits.flatMap((x, k): (number | null)[][] => (isFinite(x) && x > 0 ? [[x, ys[k]!], [x, ys[k + 1]!]] : [[null, null]]));
  return {
    grid: { left: 52, right: 10, top: 8, bottom: 42 },
    xAxis: scale(map.x, xs, 26),
    yAxis: scale(map.y, ys, 36),
    tooltip: { ...tooltip(), trigger: 'item', formatter },
    series: [
      {
        type: 'custom',
        renderItem,
        clip: true,
        data: map.measured.map((_, cell) => [cell, map.x.values[cell % width]!, map.y.values[Math.floor(cell / width)]!]),
        encode: { x: 1, y: 2 },
      },
      { type: 'line', data: limits, symbol: 'none', silent: true, clip: true, connectNulls: false, lineStyle: { color: '#000', width: 1.5 } },
    ],
  } as Option;
}

function mapFigure(map: GrowthMap): HTMLElement {
  const place = make('div', { class: 'chart', role: 'img', 'aria-label': `${map.title}, ${readableName(map.method)}` });
  new Chart(place, () => mapOption(map));
  return make('figure', { class: 'card' }, make('figcaption', {}, readableName(map.method)), place);
}

function mapsOf(maps: readonly GrowthMap[]): HTMLElement {
  const families = [...new Set(maps.map(({ title }) => title))];
  const holder = make('div', { class: 'maps' });
  const show = (index: number): void => holder.replaceChildren(...maps.filter(({ title }) => title === families[index]).map(mapFigure));
  show(0);
  const about =
    'Each cell is measured: blue stays (light) or dies away (dark), orange to brown grows with every step. The black line is the limit by analysis.';
  return make('div', {}, make('p', { class: 'hint' }, about), choice('Family', families, show), holder);
}

export function stabilitySection({ cases = [], maps = [] }: Partial<Stability>): HTMLElement {
  const section = make('section', { id: 'stability' }, make('h2', {}, 'Stability'));
  if (maps.length > 0) section.append(mapsOf(maps));
  if (cases.length === 0) return section;
  const missed = cases.filter(({ passed }) => !passed).length;
  const rows = cases.map((each) => ({
    cells: [
      number(each.number), words(each.name), words(each.precision), words(each.expected, 'wrap'), number(each.bar), number(each.got),
      words(each.unit), words(each.passed ? 'met' : 'MISSED', each.passed ? '' : 'no'), words(each.note, 'wrap'),
    ],
  }));
  const head = ['', 'case', 'precision', 'expected', 'bar', 'got', '', '', 'note'];
  section.append(make('h3', {}, 'Hard cases'), make('p', {}, `${cases.length} bars, ${missed === 0 ? 'all met' : `${missed} missed`}.`), table(head, rows));
  return section;
}
