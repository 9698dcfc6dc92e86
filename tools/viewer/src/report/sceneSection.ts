// One scene of the report: its charts, which methods they show, and its tables.
import { Chart, type Option } from './chart';
import { type Machine, type SceneReport, namesIn, precisionsIn, readableName } from './data';
import { energyOverTime, longRunOption } from './energy';
import { make } from './html';
import { key, stylesOf } from './style';
import { allRuns, beyondTable, cheapestTable, claimsTable, facts, leftOut, longRunTable } from './tables';
import { throughputKeys, throughputOption, throughputTable } from './throughput';
import { workPrecision } from './workPrecision';

// Makes boxes that turn items on and off; `changed` gets the items that are on.
function boxes(title: string, names: readonly string[], label: (name: string) => Node[], isOn: (name: string) => boolean, changed: (on: Set<string>) => void) {
  const on = new Set(names.filter(isOn));
  const items = names.map((name) => {
    const box = make('input', { type: 'checkbox', value: name });
    box.checked = on.has(name);
    box.addEventListener('change', () => {
      if (box.checked) on.add(name);
      else on.delete(name);
      changed(new Set(names.filter((each) => on.has(each))));
    });
    return make('label', {}, box, ...label(name));
  });
  return { on, element: make('fieldset', {}, make('legend', {}, title), ...items) };
}

function chart(label: string, kind: string, option: () => Option): { place: HTMLElement; chart: Chart } {
  const place = make('div', { class: `chart ${kind}`, role: 'img', 'aria-label': label });
  return { place, chart: new Chart(place, option) };
}

export function sceneSection(scene: SceneReport, machine: Machine, id: string): HTMLElement {
  const names = namesIn(scene);
  const precisions = precisionsIn(scene);
  const styles = stylesOf(names);
  const charts: Chart[] = [];
  const draw = (label: string, kind: string, option: () => Option): HTMLElement => {
    const made = chart(`${scene.scene}: ${label}`, kind, option);
    charts.push(made.chart);
    return made.place;
  };
  const update = (): void => charts.forEach((each) => each.update());
  let shownNames: ReadonlySet<string> = new Set(names);
  const [first] = precisions;
  let shownPrecisions: ReadonlySet<string> = new Set([first!]);
  const methods = boxes('Methods', names, (name) => [key(styles.get(name)!), new Text(readableName(name))], () => true, (on) => {
    shownNames = on;
    update();
  });
  const kinds = boxes('Precision', precisions, (name) => [new Text(name)], (name) => name === first, (on) => {
    shownPrecisions = on;
    update();
  });

  const section = make('section', { id }, make('h2', {}, scene.scene), make('p', {}, scene.about), facts(scene));
  section.append(make('div', { class: 'card' }, methods.element, ...(precisions.length > 1 ? [kinds.element] : []),
    draw('speed against error', '', () => workPrecision(scene, styles, { names: shownNames, precisions: shownPrecisions }))));
  section.append(cheapestTable(scene), beyondTable(scene));
  if (scene.energy_curves.length > 0 && scene.energy_scale > 0) {
    section.append(make('h3', {}, 'Energy over time'), make('p', { class: 'hint' }, `In float64, at the scene's own step; dashed grey is the reference. The boxes above choose the methods.`),
      make('div', { class: 'card' }, draw('energy over time', 'low', () => energyOverTime(scene, styles, shownNames))));
  }
  const { long_run: longRun = [], claims = [], throughput = [] } = scene;
  const [longest] = longRun;
  if (longest) {
    section.append(make('h3', {}, 'Energy in the long run'),
      make('p', { class: 'hint' }, `${longest.steps} steps of Ωh = ${longest.omega_h} in float64, energies averaged over five periods.`),
      make('div', { class: 'card' }, draw('energy in the long run', 'low', () => longRunOption(longRun, styles, shownNames))), longRunTable(longRun));
  }
  if (throughput.length > 0) {
    section.append(make('h3', {}, 'Throughput over size'),
      make('p', { class: 'hint' }, 'The scene with fewer or more particles, from its start and at its own step and methods. Bands: the caches that positions and velocities fit into, of all threads together, in the first precision shown.'),
      make('div', { class: 'card' }, draw('throughput over size', 'low', () => throughputOption(machine, throughput, shownPrecisions)), throughputKeys(throughput)), throughputTable(throughput));
  }
  if (claims.length > 0) section.append(claimsTable(claims));
  section.append(allRuns(scene), leftOut(scene));
  return section;
}
