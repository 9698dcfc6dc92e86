// Colours that also differ in lightness, so that everyone can tell them apart, in print too.

export type Colour = readonly [number, number, number]; // 0..1

const hex = (text: string): Colour => [0, 2, 4].map((at) => parseInt(text.slice(at, at + 2), 16) / 255) as unknown as Colour;

// Eight points of viridis (S. van der Walt, N. Smith), without the darkest, which are lost on a dark ground.
export const rising: readonly Colour[] = ['3b528b', '31688e', '26828e', '1f9e89', '35b779', '6ece58', 'b5de2b', 'fde725'].map(hex);

export const cssGradient = (colours: readonly Colour[]): string =>
  `linear-gradient(to right, ${colours.map((c) => `rgb(${c.map((part) => Math.round(255 * part)).join(' ')})`).join(', ')})`;

// Okabe and Ito's colours without black, for curves.
export const distinct = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#b8a800', '#7f7f7f'] as const;

export const isDark = (): boolean => matchMedia('(prefers-color-scheme: dark)').matches;
