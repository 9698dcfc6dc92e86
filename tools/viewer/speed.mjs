// node speed.mjs FILE.html...: how many pictures a second pages show that play, and how large they are, in headless Chromium
// drawing by the processor. Ten seconds each, after all frames are loaded.
import { readFileSync, statSync } from 'node:fs';
import { basename } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const { quiet, drawn } = JSON.parse(readFileSync(new URL('tests/pages/chromium.json', import.meta.url), 'utf8'));
const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node speed.mjs FILE.html...');
  process.exit(2);
}

async function played(page) {
  const { count, drawn: pictures } = await page.evaluate(() => window.dvdx());
  return { count, pictures, at: performance.now() };
}

const executablePath = process.env.DVDX_CHROMIUM ?? '/usr/bin/chromium';
const browser = await chromium.launch({ executablePath, args: [...quiet, ...drawn] });
for (const file of files) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await page.goto(pathToFileURL(file).href);
  await page.waitForFunction(() => window.dvdx?.().loaded === window.dvdx?.().frames && window.dvdx?.().drawn > 0, undefined, { timeout: 120000 });
  const from = await played(page);
  await page.waitForTimeout(10000);
  const to = await played(page);
  const rate = (1000 * (to.pictures - from.pictures)) / (to.at - from.at);
  const { frames } = await page.evaluate(() => window.dvdx());
  const size = (statSync(file).size / 1e6).toFixed(1);
  console.log(`${basename(file)}: ${rate.toFixed(1)} pictures/s, ${frames} frames, ${to.count} particles shown, ${size} MB`);
  await page.close();
}
await browser.close();
