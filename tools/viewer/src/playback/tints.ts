// The colour of each particle in a frame.
import { type Colour, rising } from '../shared/palette';
import type { Frame } from './frames';

export type Colouring = 'plain' | 'speed' | 'error' | 'stretch';

export const errorOctaves = 27; // that the palette spans: eight powers of ten

// The values at the palette's end.
export interface Highest {
  speed: number; // m/s
  error: number; // m
}

// Returns the colour at a part of the palette, 0..1, as red, green and blue of 0..255.
function coloured(part: number): Colour {
  const at = Math.min(1, Math.max(0, part)) * (rising.length - 1);
  const below = rising[Math.floor(at)]!;
  const above = rising[Math.ceil(at)]!;
  return below.map((from, i) => Math.round(255 * (from + (at % 1) * (above[i]! - from)))) as unknown as Colour;
}

function speedPart(byte: number, frame: Frame, highest: Highest): number {
  return highest.speed > 0 ? (byte / 255) * (frame.speed / highest.speed) : 0;
}

function errorPart(byte: number, frame: Frame, highest: Highest): number {
  return byte === 0 ? 0 : 1 + (Math.log2(frame.error / highest.error) + (byte - 255) / 8) / errorOctaves;
}

const isByError = (frame: Frame, colouring: Colouring): boolean => colouring === 'error' && frame.errors !== undefined;

// Returns the values that the particles' colours stand for.
export function valuesOf(frame: Frame, colouring: Colouring): Uint8Array {
  if (isByError(frame, colouring)) return frame.errors!;
  return (colouring === 'stretch' ? frame.stretches : undefined) ?? frame.speeds;
}

// Returns the colours of values 0 to 255 in a frame.
export function colourTable(frame: Frame, colouring: Colouring, highest: Highest, plain: Colour): Colour[] {
  const part = isByError(frame, colouring) ? errorPart : colouring === 'stretch' ? (byte: number) => byte / 255 : speedPart;
  const all = plain.map((each) => Math.round(255 * each)) as unknown as Colour;
  return Array.from({ length: 256 }, (_, byte) => (colouring === 'plain' ? all : coloured(part(byte, frame, highest))));
}

// Writes red, green, blue and a spare byte of each particle to `tints`.
export function fillTints(tints: Uint8Array, frame: Frame, colouring: Colouring, highest: Highest, plain: Colour): void {
  const values = valuesOf(frame, colouring);
  const colours = colourTable(frame, colouring, highest, plain);
  for (let i = 0; i < frame.count; ++i) {
    const [red, green, blue] = colours[values[i]!]!;
    tints[4 * i] = red!;
    tints[4 * i + 1] = green!;
    tints[4 * i + 2] = blue!;
  }
}
