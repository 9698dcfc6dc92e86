// report.json and stability.json, as dvdx writes them. Numbers that are not finite are null there.

export type Num = number | null;

export interface Run {
  method: string;
  curve?: string; // of networks: the scheme and its options
  baseline: boolean;
  scheme: string | null;
  precision: string;
  step: number; // s
  steps: number;
  substeps: number;
  isa: string;
  threads: number;
  layout: string;
  arithmetic: string;
  ns_per_particle_step: number;
  seconds_per_simulated_second: number;
  error: { position_rms: Num; position_max: Num; velocity_rms: Num; relative: Num };
  energy_drift: Num;
  order: Num;
  in_fit: boolean;
  diverged: boolean;
  ranked?: boolean; // of networks: false if the run is no nearer to the reference than chaos leaves any two starts
  beyond?: { value: Num; off: Num; agrees: boolean }[]; // in the order of the scene's statistics
}

export interface Horizon {
  seconds: number;
  whole: boolean;
  ended_by: 'growth' | 'doubt' | null;
  growth?: Num; // of a small difference at the start until then
}

export interface Beyond {
  starts: number;
  nudge: number; // m
  apart: number; // m
  most_off: number;
  statistics: { name: string; unit: string; mean: Num; spread: Num }[];
}

export interface Order {
  method: string;
  precision: string;
  fitted: Num;
  theory: Num;
  note: string;
}

export interface EnergyCurve {
  method: string;
  times: number[]; // s
  energy: Num[]; // J
}

export interface LongRun {
  method: string;
  omega_h: number;
  steps: number;
  energy_ratio: Num;
  energy_ratio_by_matrix: Num;
  energy_ratio_by_formula: Num;
  determinant: string;
  verdict: string;
  agrees_within_1_percent: boolean;
  curve: { steps: number[]; energy_ratio: Num[] };
}

export interface Claim {
  claim: string;
  where: string;
  expected: string;
  measured: Num;
  verdict: string;
}

export interface Throughput {
  precision: string;
  particles: number;
  state_bytes: number; // of all particles
  steps_per_call: number;
  ns_per_particle_step: number;
  repeats: number;
}

export interface SceneReport {
  scene: string;
  about: string;
  particles: number;
  error_particles: number;
  step: number; // s
  duration: number; // s
  reference: {
    kind: string; self_error: number; made_of?: 'formula' | 'impacts' | 'finer_steps'; most_impacts?: number; no_closed_form?: string;
    step?: number; substeps?: number; settled?: boolean; horizon?: Horizon;
  };
  beyond?: Beyond;
  no_beyond?: string;
  amplitude: number; // m
  energy_scale: number; // J
  energy_drift_against: string;
  runs: Run[];
  orders: Order[];
  energy_curves: EnergyCurve[];
  left_out?: { curve: string; precision: string; why: string }[];
  long_run?: LongRun[];
  claims?: Claim[];
  throughput?: Throughput[];
}

export interface Cache {
  level: number;
  bytes: number;
  processors: number; // that share it
}

export interface Machine {
  cpu: string;
  cores: number;
  threads: number;
  isa: string;
  isas: string[];
  system: string;
  compiler: string;
  flags: string;
  version: string;
  date: string;
  caches: Cache[];
}

export interface Report {
  machine: Machine;
  scenes: SceneReport[];
}

export interface MapAxis {
  name: string;
  values: number[];
  spacing: 'linear' | 'logarithmic';
}

export interface GrowthMap {
  name: string;
  title: string;
  method: string;
  x: MapAxis;
  y: MapAxis;
  analysed: Num[]; // rows of x
  measured: Num[];
  limits: Num[]; // a row
}

export interface StabilityCase {
  number: number;
  name: string;
  precision: string;
  expected: string;
  bar: Num;
  got: Num;
  unit: string;
  passed: boolean;
  note: string;
}

export interface Stability {
  cases: StabilityCase[];
  maps: GrowthMap[];
}

// The name that the runs of one curve have in common.
export const nameOf = (run: Run): string => run.curve ?? run.method;

export const nsPerParticleSecond = (run: Run): number => run.ns_per_particle_step / run.step;

export const isFinite = (value: Num | undefined): value is number => typeof value === 'number' && Number.isFinite(value);

// In the order in which the report has them.
export const namesIn = (scene: SceneReport): string[] => [...new Set(scene.runs.map(nameOf))];

export const precisionsIn = (scene: SceneReport): string[] => [...new Set(scene.runs.map(({ precision }) => precision))];

export const readableName = (name: string): string => name.replace(/^baseline_/, 'plain ').replaceAll('_', ' ');

export const errorGoals = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6] as const;

export interface Cheapest {
  name: string;
  precision: string;
  isBaseline: boolean;
  runs: (Run | undefined)[]; // one for each goal
  best: Run | undefined; // with the least error
  divergedSteps: number[]; // s, sub-steps of networks
  unranked: number; // runs
}

// The cheapest run of each curve and precision that reaches each goal.
export function cheapestOf(scene: SceneReport): Cheapest[] {
  const all = new Map<string, Cheapest>();
  for (const run of scene.runs) {
    const name = nameOf(run);
    const key = `${name}/${run.precision}`;
    const found = all.get(key) ?? {
      name, precision: run.precision, isBaseline: run.baseline, runs: errorGoals.map(() => undefined), best: undefined, divergedSteps: [], unranked: 0,
    };
    all.set(key, found);
    const error = run.error.relative;
    if (run.diverged || !isFinite(error)) {
      found.divergedSteps.push(run.step / run.substeps);
      continue;
    }
    if (run.ranked === false) {
      found.unranked += 1;
      continue;
    }
    if (!found.best || error < found.best.error.relative!) found.best = run;
    errorGoals.forEach((goal, i) => {
      const so = found.runs[i];
      if (error <= goal && (!so || nsPerParticleSecond(run) < nsPerParticleSecond(so))) found.runs[i] = run;
    });
  }
  return [...all.values()];
}
