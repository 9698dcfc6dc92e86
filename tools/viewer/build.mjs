// Builds every page as one HTML file without anything beside it: node build.mjs [FOLDER]
import { resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

const root = fileURLToPath(new URL('.', import.meta.url));
const outDir = resolve(process.argv[2] ?? `${root}/dist`);

for (const page of ['playback', 'report']) {
  await build({
    root,
    configFile: false,
    logLevel: 'warn',
    plugins: [viteSingleFile({ removeViteModuleLoader: true })],
    build: {
      outDir,
      emptyOutDir: false,
      chunkSizeWarningLimit: 4096,
      rollupOptions: { input: resolve(root, `${page}.html`) },
    },
  });
}
