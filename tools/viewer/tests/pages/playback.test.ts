// Real scenes, run, opened from disk, played and scrubbed.
import { readFileSync, writeFileSync } from 'node:fs';
import type { Browser, Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';
import { Scratch, barriers, colours, launched, opened, settings } from './browser';

interface Shown {
  frames: number;
  loaded: number;
  frame: number;
  step: number;
  time: number;
  count: number;
  drawn: number;
  isPlaying: boolean;
  positions: number[];
}

const shown = (page: Page): Promise<Shown> =>
  page.evaluate(() => {
    const state = window.dvdx!();
    return { ...state, positions: [...state.positions.slice(0, 30)] };
  });

const whole = (page: Page): Promise<unknown> =>
  page.waitForFunction(() => {
    const state = window.dvdx?.();
    return state !== undefined && state.loaded === state.frames && state.drawn > 0;
  }, undefined, { timeout: 60000 });

// Once the picture is of what is shown now.
const settled = (page: Page): Promise<void> =>
  page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve()))));

async function scrub(page: Page, part: number): Promise<void> {
  await page.locator('#scrub').evaluate((slider: HTMLInputElement, at: number) => {
    slider.value = String(at * Number(slider.max));
    slider.dispatchEvent(new Event('input'));
  }, part);
  await settled(page);
}

interface Placed {
  outside: number; // particles that are not where nothing covers the picture
  size: number; // of the box around the first `count` of them, as a part of the free height
}

const placed = (page: Page, count = Infinity): Promise<Placed> =>
  page.evaluate((most) => {
    const { seen, positions } = window.dvdx!();
    const { clientWidth, clientHeight } = document.querySelector('#picture')!;
    const top = document.querySelector('#top')!.getBoundingClientRect().bottom;
    const bottom = document.querySelector('footer')!.getBoundingClientRect().top;
    let outside = 0;
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < Math.min(most, positions.length / 3); ++i) {
      const [x, y, z] = positions.subarray(3 * i, 3 * i + 3) as unknown as [number, number, number];
      const row = (r: number): number => seen[r]! * x + seen[4 + r]! * y + seen[8 + r]! * z + seen[12 + r]!;
      const across = 0.5 * clientWidth * (1 + row(0) / row(3));
      const down = 0.5 * clientHeight * (1 - row(1) / row(3));
      if (!(across >= 0 && across <= clientWidth && down >= top && down <= bottom && row(3) > 0)) ++outside;
      low = Math.min(low, down);
      high = Math.max(high, down);
    }
    return { outside, size: (high - low) / (bottom - top) };
  }, count);

// Texts and controls that go beyond the panel that they are in, or beyond the window.
const astray = (page: Page): Promise<string[]> =>
  page.evaluate(() =>
    ['footer', '#top'].flatMap((holder) => {
      const box = document.querySelector(holder)!.getBoundingClientRect();
      const [left, right] = [Math.max(0, box.left), Math.min(innerWidth, box.right)];
      return [...document.querySelectorAll(`${holder} :not(option)`)].flatMap((each) => {
        const { left: from, right: to, bottom, width } = each.getBoundingClientRect();
        return width === 0 || from >= left - 1 && to <= right + 1 && bottom <= box.bottom + 1 ? [] : [`${each.tagName} ${each.textContent}`];
      });
    }),
  );

// step -> how many particles, and x, y, z of the first of them, as the run wrote them; a state without particles has no rows.
function csvPositions(file: string): Map<number, number[]> & { counts: Map<number, number> } {
  const states = Object.assign(new Map<number, number[]>(), { counts: new Map<number, number>() });
  for (const row of readFileSync(file, 'utf8').trim().split('\n').slice(1)) {
    const cells = row.split(',').map(Number);
    const state = states.get(cells[0]!) ?? [];
    if (cells[2]! < 10) state.push(...cells.slice(3, 6));
    states.set(cells[0]!, state);
    states.counts.set(cells[0]!, cells[2]! + 1);
  }
  return states;
}

describe.skipIf(settings.program === undefined)('the playback page', () => {
  const scratch = new Scratch();
  let browser: Browser;
  beforeAll(async () => {
    browser = await launched('with WebGL');
  });
  afterAll(async () => {
    await browser.close();
    scratch.remove();
  });

  const scenes = [
    { name: 'flag', count: 6144, spacing: 2e-4, options: ['--duration', '0.5'], says: '6,144 particles' },
    { name: 'hail', count: 20000, spacing: 5e-3, options: ['--set', 'particles.count=20000', '--duration', '1'], says: '20,000 particles' },
    { name: 'two-springs', count: 1, spacing: 1e-6, options: ['--every', '20'], says: '1 particle' },
  ];

  test.each(scenes)('$name loads, plays and scrubs', async ({ name, count, spacing, options, says }) => {
    const run = ['run', `${settings.scenes}/${name}.json`, ...options];
    const every = name === 'two-springs' ? [] : ['--every', '10'];
    scratch.dvdx(...run, ...every, '--out', scratch.path(`${name}.html`));
    scratch.dvdx(...run, ...every, '--out', scratch.path(`${name}.csv`));
    const states = csvPositions(scratch.path(`${name}.csv`));
    const { page, complaints } = await opened(browser, scratch.path(`${name}.html`));
    await whole(page);
    expect(await page.locator('#count').textContent()).toBe(says);
    expect((await shown(page)).count).toBe(count);
    expect((await shown(page)).frames).toBe(states.size);

    // It plays by itself, and stops; the button says what it does.
    const before = await shown(page);
    expect(before.isPlaying).toBe(true);
    await page.waitForFunction((time) => window.dvdx!().time !== time, before.time);
    const play = page.locator('#play');
    expect(await play.getAttribute('aria-label')).toBe('Pause');
    await page.keyboard.press(' ');
    expect((await shown(page)).isPlaying).toBe(false);

    // Every state that is scrubbed to is the run's own, and seen whole beside the panel.
    for (const part of [0, 0.5, 1]) {
      await scrub(page, part);
      expect((await placed(page)).outside).toBe(0);
      const state = await shown(page);
      const expected = states.get(state.step)!;
      if (part === 0) expect(state.step).toBe(0);
      if (part === 1) expect(state.step).toBe([...states.keys()].at(-1));
      expected.forEach((x, i) => expect(Math.abs(state.positions[i]! - x)).toBeLessThan(spacing));
    }

    expect(await play.getAttribute('aria-label')).toBe('Play');
    const text = await page.locator('#scrub').getAttribute('aria-valuetext');
    expect(text).toMatch(/^[0-9.]+ of [0-9.]+ s$/);
    expect(text).toBe(await page.locator('#time').textContent());

    // So they are in the window of a telephone, where all texts keep to their panel.
    await page.setViewportSize({ width: 375, height: 667 });
    await settled(page);
    expect(await astray(page)).toEqual([]);
    expect((await placed(page)).outside).toBe(0);
    await page.setViewportSize({ width: 1280, height: 800 });
    await settled(page);

    // Keys: a frame back, the view turned; the picture is a picture.
    const last = await shown(page);
    await page.keyboard.press('ArrowLeft');
    await page.waitForFunction((frame) => window.dvdx!().frame === frame - 1, last.frame);
    const drawn = (await shown(page)).drawn;
    await page.keyboard.press('d');
    await page.waitForFunction((pictures) => window.dvdx!().drawn > pictures, drawn);
    const hidden = '#message, header, footer, aside { visibility: hidden }';
    const ground = await page.screenshot({ style: `${hidden} canvas { visibility: hidden }` });
    const picture = await page.screenshot({ style: hidden });
    expect(picture.equals(ground)).toBe(false);
    expect(colours(picture)).toBeGreaterThan(colours(ground) + 10);
    expect(complaints).toEqual([]);
    await page.close();
  }, 120000);

  test('what a motion carries is drawn where it is, and pins are marked', async () => {
    const contact = { type: 'sphere', center: [0, 0, 0], radius: 0.3, motion: 'aside' };
    const motions = { aside: { keys: [{ time: 0 }, { time: 1, translation: [1, 0, 0] }] } };
    const scene = {
      format: 'dvdx-scene/1', name: 'aside', step: 0.05, duration: 1, motions, contacts: [contact], fixed: [0, 1],
      particles: { count: 2, position: { values: [[-2, -1, 0], [2, 1, 0]] } },
    };
    writeFileSync(scratch.path('aside.json'), JSON.stringify(scene));
    scratch.dvdx('run', scratch.path('aside.json'), '--every', '1', '--out', scratch.path('aside.html'));
    const { page, complaints } = await opened(browser, scratch.path('aside.html'));
    await whole(page);
    await page.keyboard.press(' ');
    const hidden = '#message, header, footer, aside { visibility: hidden }';
    const pictureAt = async (part: number): Promise<Buffer> => {
      const { drawn } = await shown(page);
      await page.locator('#scrub').evaluate((slider: HTMLInputElement, at: number) => {
        slider.value = String(at * Number(slider.max));
        slider.dispatchEvent(new Event('input'));
      }, part);
      await page.waitForFunction((pictures) => window.dvdx!().drawn > pictures, drawn);
      return page.screenshot({ style: hidden });
    };
    const half = await pictureAt(0.5);
    const end = await pictureAt(1);
    expect(end.equals(half)).toBe(false); // nothing but the sphere moves
    const { drawn } = await shown(page);
    await page.keyboard.press('n');
    await page.waitForFunction((pictures) => window.dvdx!().drawn > pictures, drawn);
    expect((await page.screenshot({ style: hidden })).equals(end)).toBe(false);
    expect(complaints).toEqual([]);
    await page.close();
  }, 120000);

  test('particles that come and go are counted, and each is followed', async () => {
    const run = ['run', `${settings.scenes}/fountain.json`, '--duration', '3', '--every', '6'];
    scratch.dvdx(...run, '--out', scratch.path('fountain.html'));
    scratch.dvdx(...run, '--out', scratch.path('fountain.csv'));
    const states = csvPositions(scratch.path('fountain.csv'));
    const { page, complaints } = await opened(browser, scratch.path('fountain.html'));
    await whole(page);
    await page.keyboard.press(' ');
    for (const part of [0, 0.1, 0.7, 1]) {
      await page.locator('#scrub').evaluate((slider: HTMLInputElement, at: number) => {
        slider.value = String(at * Number(slider.max));
        slider.dispatchEvent(new Event('input'));
      }, part);
      const state = await shown(page);
      expect(state.count).toBe(states.counts.get(state.step) ?? 0);
      (states.get(state.step) ?? []).forEach((x, i) => expect(Math.abs(state.positions[i]! - x)).toBeLessThan(1e-3));
      const says = `${new Intl.NumberFormat('en').format(state.count)} particles`;
      await page.waitForFunction((text) => document.querySelector('#count')?.textContent === text, says);
    }
    expect((await shown(page)).count).toBeGreaterThan(15000);
    expect(colours(await page.screenshot({ style: '#message, header, footer, aside { visibility: hidden }' }))).toBeGreaterThan(50);
    expect(complaints).toEqual([]);
    await page.close();
  }, 120000);

  test('a crowd that walks is followed, and one that is far away makes it no smaller', async () => {
    const values = Array.from({ length: 60 }, (_, i) => [(i % 4) / 4, (i % 5) / 5, (i % 3) / 3]);
    const scene = {
      format: 'dvdx-scene/1', name: 'walk', step: 0.05, duration: 4,
      particles: { count: 61, position: { values: [...values, [0, 4000, 0]] }, velocity: [5, 0, 1] },
    };
    writeFileSync(scratch.path('walk.json'), JSON.stringify(scene));
    scratch.dvdx('run', scratch.path('walk.json'), '--every', '1', '--out', scratch.path('walk.html'));
    const { page, complaints } = await opened(browser, scratch.path('walk.html'));
    await whole(page);
    await page.keyboard.press(' ');
    for (const part of [0, 0.4, 1]) {
      await scrub(page, part);
      const { outside, size } = await placed(page, 60);
      expect(outside).toBe(0);
      expect(size).toBeGreaterThan(0.3);
    }
    expect(complaints).toEqual([]);
    await page.close();
  }, 60000);

  test('axe-core finds nothing serious, neither in light nor in dark', async () => {
    const { page } = await opened(browser, scratch.path('walk.html'));
    await whole(page);
    await page.keyboard.press(' ');
    await page.locator('summary').click();
    await page.emulateMedia({ colorScheme: 'light' });
    expect(await barriers(page)).toEqual([]);
    await page.emulateMedia({ colorScheme: 'dark' });
    expect(await barriers(page, ['color-contrast'])).toEqual([]);
    await page.close();
  }, 60000);

  test('without WebGL the page says so and what to do', async () => {
    const blind = await launched('without WebGL');
    scratch.dvdx('run', `${settings.scenes}/one-spring.json`, '--out', scratch.path('blind.html'));
    const { page, complaints } = await opened(blind, scratch.path('blind.html'));
    const message = page.locator('#message');
    await message.getByText('WebGL 2').waitFor();
    expect(await message.textContent()).toContain('hardware acceleration');
    expect(await page.locator('#name').textContent()).toBe('one spring');
    expect(complaints).toEqual([]);
    await blind.close();
  }, 60000);
});
