// The page of `dvdx report`.
import './report.css';
import { element, takenText } from '../shared/page';
import type { Machine, Report, Stability } from './data';
import { make } from './html';
import { sceneSection } from './sceneSection';
import { stabilitySection } from './stability';

function cachesText({ caches }: Machine): string {
  const each = caches.map(({ level, bytes, processors }) => `L${level} ${bytes / 1024} KiB for ${processors === 1 ? 'each core' : `${processors} cores`}`);
  return each.length > 0 ? each.join(', ') : 'unknown';
}

function footer(machine: Machine): HTMLElement {
  const rows: [string, string][] = [
    ['dvdx', machine.version],
    ['Processor', `${machine.cpu}, ${machine.cores} cores`],
    ['Run with', `${machine.isa} on ${machine.threads} thread${machine.threads === 1 ? '' : 's'} (there are ${machine.isas.join(', ')})`],
    ['Caches', cachesText(machine)],
    ['System', machine.system],
    ['Compiler', `${machine.compiler}, flags ${machine.flags}`],
    ['Date', machine.date],
  ];
  return make('footer', {},
    make('dl', {}, ...rows.flatMap(([what, said]) => [make('dt', {}, what), make('dd', {}, said)])),
    make('p', {}, 'Times: one warm-up, then the least of at least five repeats (one where a run takes over 2 s); plans and errors are not timed. Plain loops run on one thread.'));
}

function start(): void {
  const text = takenText('report');
  if (text === undefined) throw new Error('this file holds no report: it is not whole');
  const report = JSON.parse(text) as Report;
  const stability = takenText('stability');
  const sections = report.scenes.map((scene, i) => sceneSection(scene, report.machine, `scene-${i + 1}`));
  const links = report.scenes.map(({ scene }, i) => make('a', { href: `#scene-${i + 1}` }, scene));
  if (stability !== undefined) {
    sections.push(stabilitySection(JSON.parse(stability) as Partial<Stability>));
    links.push(make('a', { href: '#stability' }, 'stability'));
  }
  element('report', HTMLElement).replaceChildren(
    make('h1', {}, 'Speed against error'),
    make('p', { class: 'lead' }, 'The cost of a simulated second, and how far it ends up from the exact motion: every method, over a range of steps. Further right is more exact, further down is faster. Point at a mark for its numbers.'),
    ...(links.length > 1 ? [make('nav', { 'aria-label': 'Scenes' }, ...links)] : []),
    ...sections,
    footer(report.machine),
  );
}

try {
  start();
} catch (reason) {
  element('report', HTMLElement).textContent = `This page cannot show its report: ${reason instanceof Error ? reason.message : String(reason)}`;
  console.error(reason);
}
