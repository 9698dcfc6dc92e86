// A scene's numbers in tables.
import {
  type Claim, type LongRun, type Order, type SceneReport, cheapestOf, errorGoals, isFinite, nameOf, nsPerParticleSecond, readableName,
} from './data';
import { power, text } from './format';
import { type Row, make, number, table, words } from './html';

const orderCell = (order: Order | undefined, which: 'fitted' | 'theory') =>
  order && order[which] === null && order.note === 'exact' ? words('exact') : number(order?.[which]);

export function cheapestTable(scene: SceneReport): HTMLElement {
  const all = cheapestOf(scene);
  const leasts = errorGoals.map((_, goal) => Math.min(...all.flatMap(({ runs }) => (runs[goal] ? [nsPerParticleSecond(runs[goal])] : []))));
  const hasUnranked = all.some(({ unranked }) => unranked > 0);
  const rows: Row[] = all.map(({ name, precision, isBaseline, runs, best, divergedSteps, unranked }) => {
    const order = scene.orders.find((each) => each.method === name && each.precision === precision);
    const goals = runs.map((run, goal) => {
      const cost = run && nsPerParticleSecond(run);
      return number(cost, cost !== undefined && cost === leasts[goal] ? 'best' : '');
    });
    return {
      kind: isBaseline ? 'baseline' : '',
      cells: [
        words(readableName(name)), words(precision), orderCell(order, 'fitted'), orderCell(order, 'theory'), ...goals,
        number(best?.error.relative), number(best?.energy_drift), words(divergedSteps.map((step) => `${text(step)} s`).join(', ')),
        ...(hasUnranked ? [words(unranked > 0 ? `${unranked} run${unranked === 1 ? '' : 's'}` : '')] : []),
      ],
    };
  });
  const head = ['method', 'precision', 'order', 'theory', ...errorGoals.map((goal) => power(goal)), 'least error', 'its energy error', 'diverged at steps of', ...(hasUnranked ? ['not ranked'] : [])];
  return make('div', {},
    make('h3', {}, 'Cheapest run that reaches an error'),
    make('p', { class: 'hint' }, 'ns per particle and simulated second; the cheapest of each column is marked. Relative errors are root mean squares over particles and sample times, over the amplitude. Order: the slope through the finest runs that are clear of rounding and below 30 % error.' +
      (hasUnranked ? ' Not ranked: runs no nearer to the reference than chaos leaves any two starts.' : '')),
    table(head, rows));
}

// Makes a table of those values of chaotic runs that can be compared; positions cannot.
export function beyondTable(scene: SceneReport): Node {
  const { beyond, no_beyond: why } = scene;
  if (!beyond) return why === undefined ? new Text() : make('p', { class: 'hint' }, `Beyond the horizon nothing is compared: ${why}.`);
  const reference: Row = {
    kind: 'baseline', cells: [words('reference'), words('float64'), number(null), ...beyond.statistics.flatMap(({ mean, spread }) => [number(mean, '', 4), number(spread, '', 2)])],
  };
  const rows = scene.runs.filter((run) => run.beyond).map((run) => ({
    cells: [
      words(readableName(nameOf(run))), words(run.precision), number(run.substeps, '', 9),
      ...run.beyond!.flatMap(({ value, off, agrees }) => [number(value, agrees ? '' : 'no', 4), number(off, agrees ? '' : 'no', 2)]),
    ],
  }));
  const head = ['method', 'precision', 'sub-steps', ...beyond.statistics.flatMap(({ name, unit }) => [unit ? `${name}, ${unit}` : name, 'off'])];
  return make('div', {},
    make('h3', {}, 'Beyond the horizon'),
    make('p', { class: 'hint' },
      `Where particles are is chance there. Means over time (of the stretch: the largest); the reference's are of ${beyond.starts} starts up to ${text(beyond.nudge)} m beside the scene's, ` +
        `which come ${text(beyond.apart)} m apart, with their spread. Off: by how many spreads; marked where by more than ${text(beyond.most_off)}, which one in a hundred is by chance.`),
    table(head, [reference, ...rows]));
}

export function longRunTable(runs: readonly LongRun[]): HTMLElement {
  const rows = runs.map((run) => ({
    cells: [
      words(readableName(run.method)), number(run.energy_ratio, '', 4), number(run.energy_ratio_by_matrix, '', 4), number(run.energy_ratio_by_formula, '', 4),
      words(run.determinant), words(run.agrees_within_1_percent ? 'yes' : 'no', run.agrees_within_1_percent ? '' : 'no'), words(run.verdict),
    ],
  }));
  return table(['method', 'E/E₀ measured', 'determinant of the step ^ steps', 'by formula', 'determinant', 'within 1 %', 'verdict'], rows);
}

export function claimsTable(claims: readonly Claim[]): HTMLElement {
  const rows = claims.map((claim) => ({
    cells: [
      words(claim.claim, 'wrap'), words(claim.where), words(claim.expected), number(claim.measured),
      words(claim.verdict, claim.verdict === 'holds' ? 'wrap' : 'wrap no'),
    ],
  }));
  return make('div', {},
    make('h3', {}, 'Brown\'s claims'),
    make('p', { class: 'hint' }, 'Ratios of the largest position errors over half a period of the two springs.'),
    table(['Brown\'s claim', 'where', 'by analysis', 'measured', 'verdict'], rows));
}

export function allRuns(scene: SceneReport): HTMLElement {
  const rows = scene.runs.map((run) => ({
    kind: run.baseline ? 'baseline' : '',
    cells: [
      words(readableName(nameOf(run))), words(run.precision), number(run.step, '', 4), number(run.steps, '', 9), number(run.substeps, '', 9),
      number(run.ns_per_particle_step), number(run.seconds_per_simulated_second), number(run.error.position_rms), number(run.error.position_max),
      number(run.error.velocity_rms), run.diverged ? words('DIVERGED', 'no') : number(run.error.relative), number(run.energy_drift),
      words(run.in_fit ? 'yes' : ''), words(run.isa), words(`${run.threads}`), words(run.layout), words(run.arithmetic),
    ],
  }));
  const head = [
    'method', 'precision', 'step, s', 'steps', 'sub-steps', 'ns per particle-step', 's per simulated s', 'position rms, m', 'position max, m',
    'velocity rms, m/s', 'relative', 'energy drift', 'in fit', 'instructions', 'threads', 'layout', 'arithmetic',
  ];
  return make('details', { class: 'runs' }, make('summary', {}, `All ${scene.runs.length} runs`), table(head, rows));
}

export function leftOut(scene: SceneReport): Node {
  const all = scene.left_out ?? [];
  if (all.length === 0) return new Text();
  const items = all.map(({ curve, precision, why }) => make('li', {}, `${readableName(curve)} in ${precision}: ${why}`));
  return make('details', {}, make('summary', {}, `${all.length} left out`), make('ul', {}, ...items));
}

function horizonText({ reference: { horizon }, duration }: SceneReport): string {
  if (!horizon || horizon.whole) return '';
  const why = horizon.ended_by === 'growth' ? `in which a difference of the start grows ${text(horizon.growth)} times` : 'beyond which it is in doubt';
  return `. Horizon: ${text(horizon.seconds)} s of ${text(duration)} s, ${why}; errors, orders and ranks are of that time`;
}

function referenceText(scene: SceneReport): string {
  const { reference } = scene;
  const own = `its own error ${text(reference.self_error)} m`;
  const isNetwork = scene.runs[0]?.scheme != null;
  const step = isFinite(reference.step) ? reference.step / (reference.substeps ?? 1) : undefined;
  const source =
    reference.kind !== 'closed_form'
      ? `the same kernel at finer steps (${isNetwork ? 'scheme fourth_order' : 'method combined'} in float64, ${text(step)} s), ` +
        `which a wrong law would not show against; halving moved it by ${text(reference.self_error)} m`
      : reference.made_of === 'impacts'
        ? `closed form from impact to impact in long double, up to ${reference.most_impacts} impacts a particle, ${own}`
        : `closed form in long double, ${own}`;
  const unsettled = reference.settled === false ? ', which is MORE than a hundredth of the smallest error shown' : '';
  return source + unsettled + horizonText(scene) + (reference.no_closed_form ? `; no closed form: ${reference.no_closed_form}` : '');
}

export function facts(scene: SceneReport): HTMLElement {
  const many = new Intl.NumberFormat('en').format(scene.particles);
  const spread = scene.error_particles === scene.particles ? '' : ` Errors on ${scene.error_particles} evenly spread particles, times on all.`;
  return make('p', { class: 'facts' },
    `${many} particle${scene.particles === 1 ? '' : 's'}, ${text(scene.duration)} s, own step ${text(scene.step, 6)} s. Amplitude ${text(scene.amplitude, 4)} m. ` +
      `Reference: ${referenceText(scene)}.${spread} Energy drift against the ${scene.energy_drift_against}.`);
}
