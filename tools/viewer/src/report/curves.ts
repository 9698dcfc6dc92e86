// Charts of curves that the reader turns on and off together.
import { type Option, axis, inks, tooltip } from './chart';
import type { Style } from './style';

export interface Point {
  x: number;
  y: number;
  told: string; // when pointed at
}

export interface Curve {
  name: string;
  style: Style;
  points: Point[];
  hasMarks: boolean;
}

export interface Frame {
  x: Record<string, unknown>;
  y: Record<string, unknown>;
}

const symbol = { circle: 'circle', rect: 'rect', triangle: 'triangle', diamond: 'diamond', pin: 'pin', arrow: 'arrow' } as const;

export function curvesOption(frame: Frame, curves: readonly Curve[], extra: Record<string, unknown> = {}): Option {
  const series = curves.map(({ style, points, hasMarks, name }, i) => ({
    type: 'line' as const,
    name,
    data: points.map(({ x, y }) => [x, y]),
    symbol: hasMarks ? symbol[style.mark] : 'none',
    symbolSize: 9,
    showAllSymbol: true,
    triggerLineEvent: true,
    itemStyle: { color: style.colour },
    lineStyle: { color: style.colour, width: 2, type: style.isDashed ? ('dashed' as const) : ('solid' as const) },
    emphasis: { focus: 'series' as const },
    ...(i === 0 ? extra : {}),
  }));
  const formatter = (at: unknown): string => {
    const { seriesIndex, dataIndex } = at as { seriesIndex: number; dataIndex: number };
    return curves[seriesIndex]?.points[dataIndex]?.told ?? '';
  };
  return { xAxis: frame.x, yAxis: frame.y, series, tooltip: { ...tooltip(), trigger: 'item', formatter } } as Option;
}

export { axis, inks };
