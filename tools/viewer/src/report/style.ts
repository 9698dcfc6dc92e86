// How each method is drawn, everywhere on the page: by colour, by mark and, for plain loops, by dashes.
import { distinct } from '../shared/palette';

export const marks = ['circle', 'rect', 'triangle', 'diamond', 'pin', 'arrow'] as const;

export interface Style {
  colour: string;
  mark: (typeof marks)[number];
  isDashed: boolean;
}

export function stylesOf(names: readonly string[]): Map<string, Style> {
  return new Map(
    names.map((name, i) => [
      name,
      { colour: distinct[i % distinct.length]!, mark: marks[(i + Math.floor(i / distinct.length)) % marks.length]!, isDashed: name.startsWith('baseline_') },
    ]),
  );
}

const shapes: Record<Style['mark'], string> = {
  circle: '<circle cx="13" cy="6" r="4"/>',
  rect: '<rect x="9" y="2" width="8" height="8"/>',
  triangle: '<path d="M13 1.5 17.5 10h-9z"/>',
  diamond: '<path d="M13 1 18 6 13 11 8 6z"/>',
  pin: '<path d="M13 11C10 7 9 6 9 4.5a4 4 0 0 1 8 0C17 6 16 7 13 11z"/>',
  arrow: '<path d="M13 1 17 11 13 8.5 9 11z"/>',
};

// Draws a style as a small picture beside the name.
export function key(style: Style): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('class', 'key');
  svg.setAttribute('viewBox', '0 0 26 12');
  svg.setAttribute('aria-hidden', 'true');
  const dashes = style.isDashed ? ' stroke-dasharray="4 3"' : '';
  svg.innerHTML = `<g fill="${style.colour}"><path d="M0 6h26" stroke="${style.colour}" stroke-width="2"${dashes}/>${shapes[style.mark]}</g>`;
  return svg;
}
