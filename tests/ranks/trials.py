#!/usr/bin/env python3
"""Trials of runs on many ranks that take too long for the tests: tests/ranks/trials.py DVDX TRIAL [COUNT] [SEED]

resume  a checkpoint at a random step, gone on from by another number of ranks and threads (200)
damage  a checkpoint with a flipped byte, or cut, or of another run: refused with the reason (100)
kill    a random rank is killed at a random moment, and the run goes on from its checkpoint (50)
scenes  every shipped scene for a few steps on 7 ranks

Each result must equal that of one process that was never stopped. Prints a line for each that does not, and a count.
"""
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENES = Path(__file__).resolve().parents[2] / 'tools' / 'scenes'
MPI = {'OMPI_ALLOW_RUN_AS_ROOT': '1', 'OMPI_ALLOW_RUN_AS_ROOT_CONFIRM': '1', 'OMPI_MCA_plm': 'isolated', 'OMPI_MCA_pml': 'ob1',
       'OMPI_MCA_btl': 'self,vader'}
SAME = ['particles', 'born', 'removed', 'dropped', 'steps', 'state_hash', 'energy', 'diverged', 'bad_particles', 'contacts', 'heating',
        'torn']

GRAVITY = {'type': 'constant', 'acceleration': [0, -9.81, 0]}
FLOOR = {'type': 'plane', 'normal': [0, 1, 0.1], 'offset': 0, 'restitution': 0.6, 'friction': 0.2}
BALL = {'type': 'sphere', 'center': [0.5, 0.8, 0.5], 'radius': 0.2, 'friction': 0.3}
HEAD = {'format': 'dvdx-scene/1', 'step': 0.0078125, 'duration': 0.625}
STEPS = 80


def grid(**more):
    return {'type': 'grid', 'rows': 12, 'columns': 9, 'origin': [0, 1, 0], 'edge_u': [1, 0, 0], 'edge_v': [0, 0.3, 1], 'mass': 0.2,
            'structural': 60, 'shear': 20, 'bend': 4, **more}


def small_scenes():
    particles = {'count': 101, 'mass': {'uniform': {'min': 0.5, 'max': 2, 'seed': 4}},
                 'position': {'uniform': {'min': [0, 0.1, 0], 'max': [1, 2, 1], 'seed': 3}},
                 'velocity': {'uniform': {'min': [-1, -1, -1], 'max': [1, 1, 1], 'seed': 5}}}
    hand = {'hand': {'keys': [{'time': 0}, {'time': 0.3, 'translation': [0.2, 0.1, 0], 'rotation': [0, 0.5, 0]}]}}
    pairs = [[i, (i * 7 + 3) % 101] for i in range(101) if i != (i * 7 + 3) % 101]
    return {
        'contacts': {**HEAD, 'particles': particles, 'forces': [GRAVITY], 'contacts': [FLOOR, BALL]},
        'moving floor': {**HEAD, 'particles': particles, 'forces': [GRAVITY], 'motions': hand,
                         'contacts': [{**FLOOR, 'motion': 'hand'}]},
        'sheet': {**HEAD, 'network': grid(fixed='corners_top', damping=0.01), 'forces': [GRAVITY], 'contacts': [BALL]},
        'fourth order': {**HEAD, 'network': grid(fixed='edge_top', scheme='fourth_order'), 'forces': [GRAVITY], 'contacts': [BALL]},
        'swept': {**HEAD, 'network': grid(rows=200, edge_v=[0, 4, 16], fixed='edge_top', damping=0.01, scheme='sequential', lines='none'),
                  'forces': [GRAVITY], 'contacts': [BALL]},
        'swept list': {**HEAD, 'network': [grid(rows=70, columns=70, fixed='corners_top', scheme='sequential', lines='none'),
                                           {'type': 'springs', 'pairs': [[0, 4800], [3, 9]], 'stiffness': 5, 'rest_length': 'start',
                                            'scheme': 'sequential', 'lines': 'none'}], 'forces': [GRAVITY], 'contacts': [BALL]},
        'sums': {**HEAD, 'network': grid(fixed='corners_top', scheme='accumulate', damping=0.01), 'forces': [GRAVITY]},
        'skin': {**HEAD, 'network': grid(), 'forces': [GRAVITY], 'motions': hand,
                 'skins': [{'particles': list(range(20, 60)), 'at_most': 0.02, 'motion': 'hand',
                            'backstop': {'normals': [0, 1, 0], 'offset': 0.005, 'radius': 0.3}}]},
        'carried': {**HEAD, 'network': grid(), 'forces': [GRAVITY], 'motions': hand, 'contacts': [BALL],
                    'kinematic': [{'particles': 'corners_top', 'motion': 'hand'}]},
        'wind': {**HEAD, 'network': grid(fixed='edge_top', aerodynamics={'density': 1.2, 'drag': 1, 'lift': 0.5}),
                 'wind': {'mean': [5, 1, 2], 'gusts': [{'amplitude': [2, 0, 1], 'angular_frequency': 9}]}, 'forces': [GRAVITY]},
        'drops': {**HEAD, 'particles': {'count': 3, 'mass': 0.01, 'position': particles['position']}, 'capacity': 300,
                  'emitters': [{'type': 'box', 'min': [0, 0, 0], 'max': [1, 0.1, 1], 'rate': 1500, 'velocity': [0, -1, 0], 'spread': 1,
                                'lifetime': {'min': 0.05, 'max': 0.4}, 'seed': 5},
                               {'type': 'point', 'at': [0, 0.5, 0], 'rate': 90, 'velocity': [1, 0, 0], 'spread': 0.2, 'seed': 6}],
                  'removal': {'outside': {'min': [-1, -1, -1], 'max': [1.05, 3, 2]}}, 'forces': [GRAVITY], 'contacts': [FLOOR]},
        'torn': {**HEAD, 'network': grid(fixed='corners_top', structural=30, tears_at=1.03), 'forces': [GRAVITY], 'contacts': [BALL]},
        'torn sweeps': {**HEAD, 'network': grid(rows=200, edge_v=[0, 4, 16], fixed='edge_top', damping=0.01, tears_at=1.03,
                                                scheme='sequential', lines='none'), 'forces': [GRAVITY], 'contacts': [BALL]},
        'torn list': {**HEAD, 'particles': particles, 'forces': [GRAVITY], 'contacts': [FLOOR],
                      'network': {'type': 'springs', 'pairs': pairs, 'stiffness': 40, 'damping': 0.05, 'rest_length': 'start',
                                  'tears_at': 1.5}},
        'list': {**HEAD, 'particles': particles, 'forces': [GRAVITY], 'contacts': [FLOOR],
                 'network': {'type': 'springs', 'pairs': pairs, 'stiffness': 40, 'damping': 0.05, 'rest_length': 'start'}},
    }


class Trials:
    def __init__(self, dvdx, count, seed, folder):
        self.dvdx, self.count, self.random, self.folder = dvdx, count, random.Random(seed), folder
        self.environment = {**os.environ, **MPI, 'DVDX_VIEWER': str(folder)}
        (folder / 'playback.html').write_text('<!-- dvdx data -->')
        self.bad = 0
        self.scenes = small_scenes()
        for name, scene in self.scenes.items():
            (folder / f'{name}.json').write_text(json.dumps({**scene, 'name': name}))

    def line(self, ranks, arguments):
        launcher = ['mpirun', '--oversubscribe', '-n', str(ranks)] if ranks else []
        return [*launcher, self.dvdx, 'run', *map(str, arguments), '--json']

    def run(self, ranks, *arguments):
        return subprocess.run(self.line(ranks, arguments), cwd=self.folder, env=self.environment, capture_output=True, text=True)

    def outcome(self, result):
        if result.returncode:
            return result.stderr
        report = json.loads(result.stdout)
        for key in ('most', 'given'):  # which one process alone looks for
            report['energy'].pop(key, None)
        return {key: report.get(key) for key in SAME}

    def files(self, start):
        return {p.name[len(start):]: p.read_bytes() for p in self.folder.glob(start + '[.-]*') if not p.name.endswith('.pvd')}

    def check(self, is_right, *what):
        if is_right:
            return
        self.bad += 1
        print('WRONG', *what, flush=True)

    def how(self):
        return ['--threads', self.random.choice([1, 1, 2]), '--layout', self.random.choice(['soa', 'aos', 'aosoa'])]

    def counted(self, what):
        """Bytes of the states or events that the checkpoint counts on."""
        data = (self.folder / 'at').read_bytes()
        length = int.from_bytes(data[20:24], 'little')
        return json.loads(data[28:28 + length])[what]['bytes']

    def resume(self):
        for n in range(self.count):
            name = self.random.choice(list(self.scenes))
            comes_and_goes = name == 'drops'
            precision = self.random.choice(['float32', 'float64'] + ([] if comes_and_goes else ['float32_compensated']))
            kind = self.random.choice(['csv', 'ply', 'vtp', 'html'] if comes_and_goes else ['csv', 'npz', 'ply', 'pc2', 'vtp'])
            every = self.random.choice([0, 7])
            first, second = self.random.choice([0, 1, 2, 3]), self.random.choice([1, 2, 3, 5])
            step = self.random.randrange(STEPS // 2 + 1, STEPS)
            often = self.random.randrange(1, 9) if precision == 'float32_compensated' else step
            what = [f'{name}.json', '--precision', precision, '--every', every]
            for start in ('whole', 'first', 'second', 'at'):
                for path in self.folder.glob(start + '*'):
                    path.unlink()
            files = lambda start: ['--out', f'{start}.{kind}', '--events', f'{start}.events.csv']
            whole = self.outcome(self.run(0, *what, *files('whole'), '--threads', 1))
            written = self.run(first, *what, *files('first'), *self.how(), '--checkpoint', 'at', '--checkpoint-every', often)
            gone_on = self.run(second, *what, *files('second'), *self.how(), '--resume', 'at')
            same = [self.files(start) == self.files('whole') for start in ('first', 'second')]
            is_right = self.outcome(written) == whole and self.outcome(gone_on) == whole and all(same)
            self.check(is_right, n, what, kind, step, first, second, same, written.stderr, gone_on.stderr)

    def damage(self):
        for n in range(self.count):
            name = self.random.choice(list(self.scenes))
            what = [f'{name}.json', '--every', 7, '--out', 'a.csv', '--events', 'e.csv']
            written = self.run(self.random.choice([0, 2, 3]), *what, '--checkpoint', 'at', '--checkpoint-every', 50)
            self.check(written.returncode == 0, n, name, written.stderr)
            for path in self.folder.glob('[ae].csv'):
                path.unlink()
            more, exit_code = [], 4
            case = self.random.randrange(4)
            path = self.folder / self.random.choice(['at', 'at', 'at.states', 'at.events'])
            data = bytearray(path.read_bytes())
            counted = len(data) if path.name == 'at' else self.counted(path.suffix[1:])
            if case == 3 or counted == 0:
                more, exit_code = self.random.choice([['--set', 'name=other'], ['--step', '0.00390625'], ['--precision', 'float64']]), 3
            elif case == 2:
                path.write_bytes(data[:self.random.randrange(counted)])
            else:
                data[self.random.randrange(counted)] ^= 1 << self.random.randrange(8)
                path.write_bytes(data)
            result = self.run(self.random.choice([1, 2, 3]), *what, *more, '--resume', 'at')
            told = result.stderr.count('dvdx: at')
            nothing = not (self.folder / 'a.csv').exists() and not (self.folder / 'e.csv').exists()
            self.check(result.returncode == exit_code and told == 1 and nothing, n, name, path.name, case, result)
            for left in self.folder.glob('at*'):
                left.unlink()

    def kill(self):
        for n in range(self.count):
            name = self.random.choice(list(self.scenes))
            ranks = self.random.choice([2, 3])
            duration = 6 if 'network' in self.scenes[name] else 60  # which takes some seconds
            what = [f'{name}.json', '--duration', duration, '--every', 100, '--threads', 1]
            whole = self.outcome(self.run(0, *what, '--out', 'whole.csv'))
            arguments = [*what, '--out', 'a.csv', '--checkpoint', 'at', '--checkpoint-every', 50]
            process = subprocess.Popen(self.line(ranks, arguments), cwd=self.folder, env=self.environment,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            end = time.time() + 60
            while not (self.folder / 'at').exists() and process.poll() is None and time.time() < end:
                time.sleep(0.02)
            time.sleep(self.random.random())
            children = Path(f'/proc/{process.pid}/task/{process.pid}/children').read_text().split() if process.poll() is None else []
            if children:
                os.kill(int(self.random.choice(children)), signal.SIGKILL)
            start = time.time()
            code = process.wait(60)
            is_ended = (code != 0 and time.time() - start < 60) if children else code == 0
            # Where the rank was killed in the last moment, the whole file may be there: but never a part of it.
            is_ended = is_ended and self.files('a') in ({}, self.files('whole'))
            result = self.run(self.random.choice([1, 2, 3]), *what, '--out', 'a.csv', '--resume', 'at')
            same = self.files('a') == self.files('whole')
            self.check(is_ended and self.outcome(result) == whole and same, n, name, ranks, children, code, is_ended, same, result.stderr)
            print(n, name, 'killed' if children else 'was over before', flush=True)
            for path in [*self.folder.glob('at*'), *self.folder.glob('*.csv')]:
                path.unlink()

    def shipped(self):
        for path in sorted(SCENES.glob('*.json')):
            scene = json.loads(path.read_text())
            what = [path, '--duration', 5 * abs(scene['step']), '--threads', 1]
            one, many = self.run(0, *what), self.run(7, *what)
            if many.returncode == 3:
                print(path.stem, 'refused:', many.stderr.splitlines()[0], flush=True)
                continue
            self.check(self.outcome(one) == self.outcome(many), path.stem, one.stderr, many.stderr)
            print(path.stem, self.outcome(many)['state_hash'] if many.returncode == 0 else '', flush=True)


def main():
    if len(sys.argv) < 3 or sys.argv[2] not in ('resume', 'damage', 'kill', 'scenes'):
        sys.exit(__doc__)
    trial = sys.argv[2]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else {'resume': 200, 'damage': 100, 'kill': 50, 'scenes': 0}[trial]
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    with tempfile.TemporaryDirectory() as folder:
        trials = Trials(str(Path(sys.argv[1]).resolve()), count, seed, Path(folder))
        {'resume': trials.resume, 'damage': trials.damage, 'kill': trials.kill, 'scenes': trials.shipped}[trial]()
    print(f'{trial}: {count} cases, {trials.bad} wrong')
    sys.exit(1 if trials.bad else 0)


main()
