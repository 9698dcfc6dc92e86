// ECharts with the parts that the page uses, in the page's colours.
import { CustomChart, LineChart } from 'echarts/charts';
import { GridComponent, MarkAreaComponent, TooltipComponent } from 'echarts/components';
import { type ECharts, init, use } from 'echarts/core';
import { SVGRenderer } from 'echarts/renderers';
import type { EChartsOption } from 'echarts/types/dist/shared';
import { isDark } from '../shared/palette';
import { power } from './format';

use([CustomChart, LineChart, GridComponent, MarkAreaComponent, TooltipComponent, SVGRenderer]);

export type Option = EChartsOption;

export const inks = (): { ink: string; soft: string; line: string; card: string } =>
  isDark()
    ? { ink: '#e9eaec', soft: '#a2a7b0', line: '#363b42', card: '#1b1e22' }
    : { ink: '#1d1f23', soft: '#5a5e66', line: '#dcdee1', card: '#ffffff' };

// Draws the chart of `option` once its place is visible, and again when its size or the page's colours change.
export class Chart {
  private chart: ECharts | undefined;

  constructor(
    readonly place: HTMLElement,
    private readonly option: () => Option,
  ) {
    new IntersectionObserver((seen, observer) => {
      if (!seen.some(({ isIntersecting }) => isIntersecting)) return;
      observer.disconnect();
      this.chart = init(place);
      this.update();
      new ResizeObserver(() => this.chart?.resize()).observe(place);
    }, { rootMargin: '400px' }).observe(place);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.update());
  }

  update(): void {
    this.chart?.setOption({ ...frame(), ...this.option() }, { notMerge: true });
  }
}

const frame = (): Option => ({
  animation: false,
  textStyle: { fontFamily: 'system-ui, sans-serif' },
  grid: { left: 64, right: 18, top: 16, bottom: 46 },
});

export const tooltip = (): NonNullable<Option['tooltip']> => {
  const { ink, line, card } = inks();
  return { confine: true, backgroundColor: card, borderColor: line, textStyle: { color: ink, fontSize: 13 } };
};

type Scale = { kind: 'value' | 'log'; isInverse?: boolean; low?: number; high?: number; marks?: (value: number) => string };

export function axis(name: string, gap: number, scale: Scale): Record<string, unknown> {
  const { ink, soft, line } = inks();
  const marks = scale.marks ?? (scale.kind === 'log' ? power : undefined);
  return {
    type: scale.kind,
    name,
    nameLocation: 'middle',
    nameGap: gap,
    nameTextStyle: { color: ink, fontSize: 13 },
    inverse: scale.isInverse ?? false,
    min: scale.low,
    max: scale.high,
    scale: true,
    axisLabel: { color: soft, formatter: marks && ((value: number) => marks(value)), hideOverlap: true },
    axisLine: { show: true, onZero: false, lineStyle: { color: soft } },
    axisTick: { show: true, lineStyle: { color: soft } },
    splitLine: { lineStyle: { color: line } },
  };
}

const safe: Record<string, string> = { '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' };

// Returns the lines of a tooltip, escaped, because their text comes from files.
export const lines = (title: string, rows: readonly (readonly [string, string])[]): string => {
  const escaped = (said: string): string => said.replace(/[&<>"]/g, (c) => safe[c]!);
  const cells = rows.map(([what, said]) => `<tr><td style="border:0;text-align:left;padding:0 1em 0 0">${escaped(what)}</td><td style="border:0;padding:0">${escaped(said)}</td></tr>`);
  return `<b>${escaped(title)}</b><table style="font-size:12.5px">${cells.join('')}</table>`;
};
