// Small pieces of the page.
import type { Num } from './data';
import { text } from './format';

type Child = Node | string;

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K, properties: Partial<Record<string, string>> = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) if (value !== undefined) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

export interface Cell {
  text: string;
  value?: Num; // in full, for the pointer and for programs that read the page
  kind?: string;
}

// A number as text, in full when pointed at.
export const number = (value: Num | undefined, kind = '', digits = 3): Cell => ({ text: text(value, digits), value: value ?? null, kind });
export const words = (said: string, kind = ''): Cell => ({ text: said, kind: `text ${kind}` });

export interface Row {
  cells: Cell[];
  kind?: string;
}

// Makes a table. The cells of the head have the kinds of the first row.
export function table(head: readonly string[], rows: readonly Row[]): HTMLElement {
  const headRow = make('tr', {}, ...head.map((name, i) => make('th', { class: rows[0]?.cells[i]?.kind?.includes('text') ? 'text' : '' }, name)));
  const body = rows.map((row) =>
    make('tr', { class: row.kind ?? '' }, ...row.cells.map(({ text: said, value, kind }) => {
      const full = typeof value === 'number' ? String(value) : undefined;
      return make('td', { class: kind ?? '', title: full, 'data-value': full }, said);
    })),
  );
  return make('div', { class: 'wide' }, make('table', {}, make('thead', {}, headRow), make('tbody', {}, ...body)));
}

export function choice(label: string, options: readonly string[], chosen: (index: number) => void): HTMLElement {
  const select = make('select', {}, ...options.map((option, i) => make('option', { value: String(i) }, option)));
  select.addEventListener('change', () => chosen(select.selectedIndex));
  return make('label', {}, `${label} `, select);
}
