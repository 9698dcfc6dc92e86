// Headless Chromium with software rendering, and pages that dvdx writes for it.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { inflateSync } from 'node:zlib';
import type axe from 'axe-core';
import { type Browser, type Page, chromium } from 'playwright-core';
import flags from './chromium.json' with { type: 'json' };

export const settings = { program: process.env['DVDX_PROGRAM'], scenes: process.env['DVDX_SCENES'] ?? '' };

export function launched(webGl: 'with WebGL' | 'without WebGL'): Promise<Browser> {
  const executablePath = process.env['DVDX_CHROMIUM'] ?? '/usr/bin/chromium';
  return chromium.launch({ executablePath, args: [...flags.quiet, ...(webGl === 'with WebGL' ? flags.drawn : flags.blind)] });
}

export class Scratch {
  readonly folder = mkdtempSync(join(tmpdir(), 'dvdx-page-'));

  path(name: string): string {
    return join(this.folder, name);
  }

  dvdx(...words: string[]): void {
    execFileSync(settings.program!, words, { stdio: ['ignore', 'ignore', 'inherit'] });
  }

  remove(): void {
    rmSync(this.folder, { recursive: true, force: true });
  }
}

// The page and all that it complained of, which must be nothing.
export async function opened(browser: Browser, file: string): Promise<{ page: Page; complaints: string[] }> {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const complaints: string[] = [];
  page.on('console', (message) => {
    // Software rendering tells that reading the picture back is slow.
    if (message.type() !== 'log' && !message.text().includes('GPU stall')) complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('request', (request) => {
    if (!/^(file|data|blob):/.test(request.url())) complaints.push(`asked for ${request.url()}`);
  });
  await page.goto(pathToFileURL(file).href);
  return { page, complaints };
}

// All that axe-core finds serious or worse, each with where it is: by all its rules, or by these.
export async function barriers(page: Page, rules?: string[]): Promise<string[]> {
  const isThere = await page.evaluate(() => 'axe' in globalThis);
  if (!isThere) await page.addScriptTag({ path: fileURLToPath(import.meta.resolve('axe-core/axe.min.js')) });
  const { violations } = await page.evaluate(
    (runOnly) => (globalThis as unknown as { axe: typeof axe }).axe.run({ resultTypes: ['violations'], ...(runOnly && { runOnly }) }),
    rules,
  );
  return violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target.join(' ')).join(', ')}`);
}

// How many colours a PNG without interlacing has, up to a thousand; RGB or RGBA of 8 bits.
export function colours(png: Buffer): number {
  const chunks: Buffer[] = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.toString('latin1', at + 4, at + 8) === 'IDAT') chunks.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  }
  const width = png.readUInt32BE(16);
  const height = png.readUInt32BE(20);
  const channels = png[25] === 6 ? 4 : 3;
  const bytes = inflateSync(Buffer.concat(chunks));
  const seen = new Set<number>();
  let above = Buffer.alloc(width * channels);
  for (let y = 0, at = 0; y < height && seen.size < 1000; ++y, at += 1 + width * channels) {
    const row = unfiltered(bytes.subarray(at + 1, at + 1 + width * channels), above, bytes[at]!, channels);
    for (let x = 0; x < row.length; x += channels) seen.add(row.readUIntBE(x, 3));
    above = row;
  }
  return seen.size;
}

function unfiltered(row: Buffer, above: Buffer, filter: number, channels: number): Buffer<ArrayBuffer> {
  const out = Buffer.alloc(row.length);
  for (let x = 0; x < row.length; ++x) {
    const left = x >= channels ? out[x - channels]! : 0;
    const up = above[x]!;
    const corner = x >= channels ? above[x - channels]! : 0;
    out[x] = row[x]! + [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter]!;
  }
  return out;
}

function paeth(left: number, up: number, corner: number): number {
  const guess = left + up - corner;
  const [a, b, c] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
  return a <= b && a <= c ? left : b <= c ? up : corner;
}
