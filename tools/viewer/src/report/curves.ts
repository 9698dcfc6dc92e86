// Charts of curves that the reader turns on and off together.
import { type Option, tooltip } from './chart';
import type { Style } from './style';

export interface Point {
  x: number;
  y: number;
  told: string; // shown when pointed at
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

export function curvesOption(frame: Frame, curves: readonly Curve[]): Option {
  const series = curves.map(({ style, points, hasMarks, name }) => ({
    type: 'line' as const,
    name,
    data: points.map(({ x, y }) => [x, y]),
    symbol: hasMarks ? style.mark : 'none',
    symbolSize: 9,
    showAllSymbol: true,
    triggerLineEvent: true,
    itemStyle: { color: style.colour },
    lineStyle: { color: style.colour, width: 2, type: style.isDashed ? ('dashed' as const) : ('solid' as const) },
    emphasis: { focus: 'series' as const },
  }));
  const formatter = (at: unknown): string => {
    const { seriesIndex, dataIndex } = at as { seriesIndex: number; dataIndex: number };
    return curves[seriesIndex]?.points[dataIndex]?.told ?? '';
  };
  return { xAxis: frame.x, yAxis: frame.y, series, tooltip: { ...tooltip(), trigger: 'item', formatter } } as Option;
}
