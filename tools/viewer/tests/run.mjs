// node run.mjs PROGRAM PAGES SCENES: types and tests of the pages; exit 77 where something that they need is not there.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const [program, pages, scenes] = process.argv.slice(2);
const root = fileURLToPath(new URL('..', import.meta.url));
const vitest = join(root, 'node_modules/vitest/vitest.mjs');
const browser = process.env.DVDX_CHROMIUM ?? '/usr/bin/chromium';

for (const [what, file] of [['the program', program], ['the pages', join(pages, 'playback.html')], ['Vitest', vitest], ['Chromium', browser]]) {
  if (existsSync(file)) continue;
  console.error(`skipped: ${what} is not there: ${file}`);
  process.exit(77);
}
const env = { ...process.env, DVDX_PROGRAM: program, DVDX_VIEWER: pages, DVDX_SCENES: scenes, DVDX_CHROMIUM: browser };

// The words of a program that must be done.
function must(...words) {
  const { status } = spawnSync(process.execPath, words, { env, cwd: root, stdio: 'inherit' });
  if (status !== 0) process.exit(status ?? 1);
}

must(join(root, 'node_modules/typescript/bin/tsc'), '--noEmit');
must(vitest, 'run');
