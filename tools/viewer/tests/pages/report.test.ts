// The page of `dvdx report`: its numbers are those of report.json, and its charts can be pointed at.
import { readFileSync, writeFileSync } from 'node:fs';
import type { Browser, Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';
import { type GrowthMap, type Report, cheapestOf, nsPerParticleSecond } from '../../src/report/data';
import { bandsOf } from '../../src/report/throughput';
import { Scratch, launched, opened, settings } from './browser';

// How long a busy machine may take to draw.
const patience = { timeout: 30000 };

// Values in full of the first table after a heading, a row each.
const tableValues = (page: Page, heading: string): Promise<(number | null)[][]> =>
  page.evaluate((text) => {
    const head = [...document.querySelectorAll('h3, summary')].find((each) => each.textContent === text);
    const rows = head?.parentElement?.querySelectorAll('tbody tr') ?? [];
    return [...rows].map((row) =>
      [...row.querySelectorAll<HTMLElement>('td')].map((cell) => (cell.dataset['value'] === undefined ? null : Number(cell.dataset['value']))),
    );
  }, heading);

// Pairs of a chart's labels that lie on one another; their boxes are some pixels higher than the letters.
function overlaps(chart: Element): string[] {
  const margin = 4;
  const labels = [...chart.querySelectorAll('svg text')].map((label) => ({ text: label.textContent, box: label.getBoundingClientRect() }));
  return labels.flatMap(({ text, box: a }, i) =>
    labels
      .slice(i + 1)
      .filter(({ box: b }) => a.right - b.left > 1 && b.right - a.left > 1 && a.bottom - b.top > margin && b.bottom - a.top > margin)
      .map((other) => `${text} on ${other.text}`),
  );
}

const map: GrowthMap = {
  name: 'springs', title: 'equal springs on one particle', method: 'exact',
  x: { name: 'frequency x step', values: [0.1, 1, 10], spacing: 'logarithmic' },
  y: { name: 'springs', values: [1, 2], spacing: 'linear' },
  analysed: [1, 1, 1, 0.5, 1, 3], measured: [1, 1, 1, 0.5, 1, null], limits: [null, 2.5],
};

describe.skipIf(settings.program === undefined)('the report page', () => {
  const scratch = new Scratch();
  let browser: Browser;
  let report: Report;
  beforeAll(async () => {
    browser = await launched('with WebGL');
    writeFileSync(scratch.path('stability.json'), JSON.stringify({ machine: {}, cases: [], maps: [map] }));
    scratch.dvdx('report', `${settings.scenes}/two-springs.json`, '--quick', '--out', scratch.folder);
    report = JSON.parse(readFileSync(scratch.path('report.json'), 'utf8')) as Report;
  }, 120000);
  afterAll(async () => {
    await browser.close();
    scratch.remove();
  });

  test('has the numbers of report.json in its tables, and its machine', async () => {
    const { page, complaints } = await opened(browser, scratch.path('report.html'));
    const scene = report.scenes[0]!;
    const cheapest = await tableValues(page, 'Cheapest run that reaches an error');
    cheapestOf(scene).forEach((each, i) => {
      const costs = each.runs.map((run) => (run ? nsPerParticleSecond(run) : null));
      expect(cheapest[i]!.slice(4, 4 + costs.length)).toEqual(costs);
      expect(cheapest[i]![4 + costs.length]).toBe(each.best?.error.relative ?? null);
    });
    const runs = await tableValues(page, `All ${scene.runs.length} runs`);
    expect(runs.length).toBe(scene.runs.length);
    scene.runs.forEach((run, i) => {
      expect(runs[i]!.slice(2, 7)).toEqual([run.step, run.steps, run.substeps, run.ns_per_particle_step, run.seconds_per_simulated_second]);
      expect(runs[i]!.slice(7, 10)).toEqual([run.error.position_rms, run.error.position_max, run.error.velocity_rms]);
    });
    const claims = await tableValues(page, 'Brown\'s claims');
    expect(claims.map((row) => row[3])).toEqual(scene.claims!.map(({ measured }) => measured));
    const throughput = await tableValues(page, `Throughput at ${scene.throughput!.length} sizes and calls`);
    expect(throughput.map((row) => row.slice(1, 5))).toEqual(
      scene.throughput!.map((one) => [one.particles, one.state_bytes, one.steps_per_call, one.ns_per_particle_step]),
    );
    expect(throughput.length).toBeGreaterThanOrEqual(4); // two sizes, each by two kinds of calls
    const footer = await page.locator('footer').textContent();
    for (const said of [report.machine.cpu, report.machine.compiler, report.machine.date]) expect(footer).toContain(said);
    expect(complaints).toEqual([]);
    await page.close();
  }, 60000);

  test('draws curves that a box turns off, and tells of a mark that is pointed at', async () => {
    const { page, complaints } = await opened(browser, scratch.path('report.html'));
    const chart = page.locator('.chart').first();
    const curves = chart.locator('svg path[stroke="#0072b2"]'); // of the first method
    await curves.first().waitFor({ state: 'attached' });
    await page.locator('input[value="combined"]').uncheck();
    await expect.poll(() => curves.count(), patience).toBe(0);
    await page.locator('input[value="combined"]').check();
    await expect.poll(() => curves.count(), patience).toBeGreaterThan(0);
    const marks = chart.locator('svg path[fill="#0072b2"]');
    const box = (await marks.last().boundingBox())!;
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await chart.getByRole('cell', { name: 'error, relative' }).waitFor();
    expect(complaints).toEqual([]);
    await page.close();
  }, 60000);

  test('draws throughput over size with a band for each cache that is in reach', async () => {
    const { page, complaints } = await opened(browser, scratch.path('report.html'));
    const place = page.locator('.chart[aria-label$="throughput over size"]');
    await place.scrollIntoViewIfNeeded();
    await place.locator('svg path[stroke="#d55e00"]').first().waitFor({ state: 'attached' });
    const { throughput } = report.scenes[0]!;
    const sizes = throughput!.map(({ particles }) => particles);
    const [one] = throughput!;
    for (const { name } of bandsOf(report.machine, one!.state_bytes / one!.particles, Math.min(...sizes), Math.max(...sizes))) {
      await place.locator('svg text', { hasText: name }).waitFor({ state: 'attached' });
    }
    expect(complaints).toEqual([]);
    await page.close();
  }, 60000);

  test('no label of a chart lies on another, and nothing goes beyond the page', async () => {
    const { page, complaints } = await opened(browser, scratch.path('report.html'));
    for (const width of [1280, 420]) {
      await page.setViewportSize({ width, height: 800 });
      const charts = await page.locator('.chart').all();
      expect(charts.length).toBeGreaterThan(2);
      for (const chart of charts) {
        await chart.scrollIntoViewIfNeeded();
        await chart.locator('svg text').first().waitFor({ state: 'attached' });
        expect(await chart.evaluate(overlaps)).toEqual([]);
      }
      expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(width);
    }
    expect(complaints).toEqual([]);
    await page.close();
  }, 60000);

  test('has no table and no name that is wider than the page', async () => {
    const scene = JSON.parse(readFileSync(`${settings.scenes}/two-springs.json`, 'utf8')) as { name: string };
    writeFileSync(scratch.path('long.json'), JSON.stringify({ ...scene, name: `a_scene_of_a_long_name_${'x'.repeat(377)}` }));
    scratch.dvdx('report', scratch.path('long.json'), '--quick', '--out', scratch.path('long'));
    for (const file of ['report.html', 'long/report.html']) {
      const { page, complaints } = await opened(browser, scratch.path(file));
      await page.evaluate(() => document.querySelectorAll('details').forEach((each) => (each.open = true)));
      for (const width of [1280, 800, 420]) {
        await page.setViewportSize({ width, height: 800 });
        // Charts follow their boxes a picture later.
        await expect.poll(() => page.evaluate(() => document.documentElement.scrollWidth), patience).toBeLessThanOrEqual(width);
        // A page narrower than 800 scrolls a table in its box; so does 800 the one of all runs, which has 17 columns.
        const boxes = await page.evaluate(() => [...document.querySelectorAll('.wide')].map((box) => ({ all: box.closest('.runs') !== null, over: box.scrollWidth - box.clientWidth })));
        expect(boxes.length).toBeGreaterThan(3);
        for (const { all, over } of boxes) if (width === 1280 || (width === 800 && !all)) expect(over).toBeLessThanOrEqual(0);
      }
      expect(complaints).toEqual([]);
      await page.close();
    }
  }, 120000);

  test('shows the stability maps that are in its folder', async () => {
    const { page, complaints } = await opened(browser, scratch.path('report.html'));
    const place = page.locator('#stability .chart');
    await place.scrollIntoViewIfNeeded();
    await place.locator('svg path[fill="#3b0f05"]').waitFor({ state: 'attached' }); // the cell that is not finite
    expect(await page.locator('#stability figcaption').textContent()).toBe('exact');
    const picture = await page.screenshot();
    expect(picture.length).toBeGreaterThan(10000);
    expect(complaints).toEqual([]);
    await page.close();
  }, 60000);
});
