"""The Python module: memory that is not copied, bits, errors, strides and lifetimes. Run by ctest, which says where dvdx is."""

import gc
import importlib.util
import inspect
import json
import os
import pathlib
import pydoc
import re
import struct
import subprocess
import sys
import tempfile
import threading
import typing
import unittest
import unittest.mock

try:
    import cffi  # noqa: F401
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-cffi python3-numpy)")
    sys.exit(77)

import dvdx

COMMAND = os.environ.get("DVDX_COMMAND", "")
ROOT = pathlib.Path(__file__).resolve().parents[2]


def lattice(count, dtype=np.float32):
    """Positions and velocities of so many particles above the ground, of shape (count, 3)."""
    numbers = np.arange(3 * count, dtype=dtype).reshape(count, 3)
    return numbers % 7 + 1, numbers % 5 - 2


def rich_scene():
    scene = dvdx.Scene()
    scene.constant(acceleration=(0, -9.81, 0))
    scene.sinusoid(acceleration=(1, 0, 0), angular_frequency=3, phase=0.5)
    scene.spring(stiffness=4, damping=0.1, anchor="start")
    scene.drag(coefficient=0.2, wind=(1, 0, 0.5))
    scene.plane(normal=(0, 1, 0), restitution=0.5, friction=0.2)
    return scene


def swept_sheet():
    """A sheet of 4 x 5, swept by generalized alpha, which carries on what its springs did."""
    scene = dvdx.Scene(mass=0.01, fixed=[0, 4])
    scene.constant(acceleration=(0, -9.81, 0))
    scene.grid(rows=4, columns=5, edge_u=(1, 0, 0), edge_v=(0, 0, 1), structural=40, shear=10)
    scene.coupling(scheme="sequential")
    return scene


def views(positions, velocities):
    """States of the same particles in memory of every kind, each with the whole memory that it lies in."""
    count, dtype = len(positions), positions.dtype
    rows = np.full((count, 8), 7, dtype)
    rows[:, 1:4], rows[:, 5:8] = positions, velocities
    gaps = np.full((6, 3 * count), 7, dtype)
    gaps[:, 1::3] = *positions.T, *velocities.T
    backwards = np.full((6, count + 2), 7, dtype)
    backwards[:, -2:0:-1] = *positions.T, *velocities.T
    named = np.zeros(count, [(name, dtype) for name in ("age", *dvdx.COLUMNS)])
    for name, column in zip(dvdx.COLUMNS, (*positions.T, *velocities.T)):
        named[name] = column
    record = np.zeros(count, [("velocity", dtype, 3), ("tint", "u1", 8), ("position", dtype, 3)])
    record["position"], record["velocity"] = positions, velocities
    return {
        "rows with padding": (dvdx.State(rows[:, 1:4], rows[:, 5:8]), rows),
        "every third": (dvdx.State(*gaps[:, 1::3]), gaps),
        "backwards": (dvdx.State(*backwards[:, -2:0:-1]), backwards),
        "fields of numbers": (dvdx.State(named), named),
        "fields of vectors": (dvdx.State(record), record),
    }


def addresses(*arrays):
    return [array.__array_interface__["data"][0] for array in arrays]


class Memory(unittest.TestCase):
    def test_a_step_moves_the_arrays_themselves(self):
        positions, velocities = lattice(100)
        before, start = addresses(positions, velocities), positions.copy()
        state = dvdx.State(positions, velocities)
        self.assertEqual(addresses(*state.arrays.values()), addresses(*positions.T, *velocities.T))
        dvdx.compile(rich_scene(), state).step(state, 10)
        self.assertEqual(addresses(positions, velocities), before)
        self.assertTrue((positions[:, 0] != start[:, 0]).all())

    def test_every_stride_gives_the_bits_of_contiguous_columns(self):
        for dtype in (np.float32, np.float64):
            positions, velocities = lattice(77, dtype)
            state = dvdx.State(*positions.T.copy(), *velocities.T.copy())
            dvdx.compile(rich_scene(), state, step=1 / 50).step(state, 20)
            for name, (view, _) in views(positions, velocities).items():
                with self.subTest(name, dtype=dtype):
                    dvdx.compile(rich_scene(), view, step=1 / 50).step(view, 20)
                    self.assertEqual(view.hash(), state.hash())

    def test_nothing_between_the_elements_is_touched(self):
        positions, velocities = lattice(50)
        for name, (view, memory) in views(positions, velocities).items():
            with self.subTest(name):
                used = np.zeros(memory.nbytes, bool)
                first = memory.__array_interface__["data"][0]
                for column in view.arrays.values():
                    for i in range(len(column)):
                        at = column[i : i + 1].__array_interface__["data"][0] - first
                        used[at : at + column.itemsize] = True
                before = np.frombuffer(memory.tobytes(), np.uint8)
                dvdx.compile(rich_scene(), view).step(view, 5)
                after = np.frombuffer(memory.tobytes(), np.uint8)
                self.assertTrue((before[~used] == after[~used]).all())
                self.assertFalse((before[used] == after[used]).all())

    def test_a_state_keeps_its_arrays_alive(self):
        def orphan():
            positions, velocities = lattice(1000)
            state = dvdx.State(positions[::2], velocities[::2])
            return state, dvdx.compile(rich_scene(), state)

        state, plan = orphan()
        positions, velocities = lattice(1000)
        other = dvdx.State(positions[::2], velocities[::2])
        gc.collect()
        for _ in range(20):
            plan.step(state)
            plan.step(other)
        self.assertEqual(state.hash(), other.hash())

    def test_a_plan_outlives_its_scene(self):
        positions, velocities = lattice(30)
        state = dvdx.State(positions, velocities)
        scene = dvdx.Scene(mass=np.linspace(1, 2, 30))
        scene.spring(stiffness=np.linspace(3, 4, 30), anchor=positions.astype(float))
        plan = dvdx.compile(scene, state)
        del scene
        gc.collect()
        plan.step(state, 3)
        self.assertTrue(np.isfinite(positions).all())


class Bits(unittest.TestCase):
    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_the_hash_is_the_commands(self):
        count = 40
        for precision in ("float32", "float64"):
            positions, velocities = lattice(count, precision)
            with self.subTest(precision):
                hash_of_command, steps = run(free_file(positions, velocities), precision)
                scene = scene_of(free_file(positions, velocities))
                state = dvdx.State(positions, velocities)
                dvdx.compile(scene, state, step=0.0625).step(state, steps)
                self.assertEqual(state.hash(), hash_of_command)

    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_the_hash_of_a_network_is_the_commands(self):
        count = 5
        positions = np.array([[i, 0, 0] for i in range(count)], np.float64)
        velocities = np.zeros_like(positions)
        velocities[:, 1] = np.arange(count)
        file = rope_file(positions, velocities)
        hash_of_command, steps = run(file, "float64")
        scene = dvdx.Scene(fixed=[0])
        scene.constant(acceleration=(0, -9.81, 0))
        scene.springs(pairs=file["network"]["pairs"], stiffness=30, rest_length="start", damping=0.01)
        state = dvdx.State(positions, velocities)
        plan = dvdx.compile(scene, state, step=0.0625)
        plan.step(state, steps)
        self.assertEqual(state.hash(), hash_of_command)
        self.assertGreaterEqual(plan.network_limit()["substeps"], 1)

    def test_every_instruction_set_gives_the_references_bits(self):
        hashes = set()
        for isa in ("reference", None):
            state = dvdx.State(*lattice(200))
            dvdx.compile(rich_scene(), state, isa=isa).step(state, 30)
            hashes.add(state.hash())
        self.assertEqual(len(hashes), 1)

    def test_slices_of_a_state_on_threads_give_the_bits_of_the_whole(self):
        scene = dvdx.Scene()
        scene.constant(acceleration=(0, -9.81, 0))
        scene.plane(normal=(0, 1, 0), restitution=0.5)
        whole = dvdx.State(*lattice(4000))
        plan = dvdx.compile(scene, whole)
        plan.step(whole, 50)
        positions, velocities = lattice(4000)
        slices = [slice(at, at + 1000) for at in range(0, 4000, 1000)]
        workers = [
            threading.Thread(target=plan.step, args=(dvdx.State(positions[part], velocities[part]), 50)) for part in slices
        ]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(dvdx.State(positions, velocities).hash(), whole.hash())


def free_file(positions, velocities):
    return {
        "format": "dvdx-scene/1", "name": "free", "step": 0.0625, "duration": 2,
        "particles": {"count": len(positions), "mass": 2, "position": {"values": positions.tolist()},
                      "velocity": {"values": velocities.tolist()}},
        "forces": [
            {"type": "constant", "acceleration": [0, -9.81, 0]},
            {"type": "polynomial", "acceleration": [[0.5, 0, 0], [0, 0.25, 0.125]]},
            {"type": "sinusoid", "acceleration": [1, 0, 2], "angular_frequency": 3, "phase": 0.5},
            {"type": "spring", "stiffness": [4, 5, 6], "damping": 0.1, "anchor": "start"},
            {"type": "radial_spring", "stiffness": 3, "damping": 0.1, "anchor": [0, 1, 0], "rest_length": 0.5},
            {"type": "drag", "coefficient": 0.2, "wind": [1, 0, 0.5], "method": "exact"},
        ],
        "contacts": [
            {"type": "plane", "normal": [0, 1, 0], "offset": -1, "restitution": 0.5, "friction": 0.2},
            {"type": "sphere", "center": [0, 0, 0], "radius": 0.75, "viscosity": 0.1, "sweep": "line"},
            {"type": "capsule", "ends": [[2, 1, 2], [4, 2, 2]], "radius": [0.5, 0.25], "thickness": 0.125, "push_out": 0.75},
            {"type": "box", "center": [5, 1, 3], "half_extents": [1, 0.5, 1], "rotation": [0, 0.5, 0], "friction": 0.5},
        ],
    }  # fmt: skip


def rope_file(positions, velocities):
    return {
        "format": "dvdx-scene/1", "name": "rope", "step": 0.0625, "duration": 2,
        "particles": {"count": len(positions), "position": {"values": positions.tolist()},
                      "velocity": {"values": velocities.tolist()}},
        "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
        "network": {"type": "springs", "pairs": [[i, i + 1] for i in range(len(positions) - 1)], "stiffness": 30,
                    "rest_length": "start", "damping": 0.01, "fixed": [0]},
    }  # fmt: skip


def scene_of(file):
    """The scene of a file's forces and contacts, whose keys are the module's keywords."""
    scene = dvdx.Scene(mass=file["particles"]["mass"])
    for item in file["forces"] + file["contacts"]:
        getattr(scene, item["type"])(**{key: value for key, value in item.items() if key != "type"})
    return scene


def run(file, precision, beside=None):
    """The state's hash at the end of `dvdx run`, and how many steps it took. beside: the folder of files that it names."""
    with tempfile.TemporaryDirectory(dir=beside) as folder:
        name = os.path.join(beside or folder, "scene.json")
        with open(name, "w", encoding="utf-8") as out:
            json.dump(file, out)
        told = subprocess.run([COMMAND, "run", name, "--precision", precision, "--json"], check=True, stdout=subprocess.PIPE)
    report = json.loads(told.stdout)
    return report["state_hash"], report["steps"]


class Faults(unittest.TestCase):
    def test_a_bad_scene_names_the_field_its_value_and_what_is_valid(self):
        state = dvdx.State(*lattice(3))
        scene = dvdx.Scene()
        scene.constant(acceleration=(0, -9.81, 0))
        scene.spring(stiffness=-40)
        with self.assertRaises(dvdx.DvdxError) as caught:
            dvdx.compile(scene, state)
        fault = caught.exception
        self.assertEqual((fault.field, fault.value), ("forces[1].stiffness", "-40"))
        self.assertIn(">= 0", fault.valid)
        self.assertEqual(str(fault), "forces[1].stiffness is -40: must be a finite number >= 0")
        with self.assertRaises(dvdx.DvdxError) as caught:
            dvdx.compile(dvdx.Scene(), state, step=float("nan"))
        self.assertEqual(caught.exception.field, "step")

    def test_a_value_that_no_scene_can_hold_is_refused_at_once(self):
        with self.assertRaisesRegex(ValueError, "verlet.*symplectic_euler"):
            dvdx.Scene().spring(stiffness=1, method="verlet")
        with self.assertRaisesRegex(TypeError, "unexpected keyword argument 'stif'"):
            dvdx.Scene().spring(stif=1, stiffness=1)
        with self.assertRaisesRegex(ValueError, "acceleration: .*three numbers"):
            dvdx.Scene().constant(acceleration=(1, 2))
        for pairs in ([[0, -1]], [[0, 1.5]], [[0, 2**32]]):
            with self.subTest(pairs), self.assertRaisesRegex(ValueError, "pairs: .*whole"):
                dvdx.Scene().springs(pairs=pairs, stiffness=1)
        with self.assertRaisesRegex(ValueError, "whole"):
            dvdx.Scene(fixed=[-1])
        with self.assertRaisesRegex(ValueError, "mmx.*reference"):
            dvdx.compile(dvdx.Scene(), dvdx.State(*lattice(1)), isa="mmx")

    def test_numbers_of_another_kind_are_refused(self):
        positions, velocities = lattice(4)
        for bad in (positions.astype(int), positions.astype(np.float16), positions.astype(">f4"), positions.astype(complex)):
            with self.subTest(bad.dtype), self.assertRaisesRegex(TypeError, "float32 or float64"):
                dvdx.State(bad, velocities)
        with self.assertRaisesRegex(TypeError, "numpy.ndarray"):
            dvdx.State(positions.tolist(), velocities)
        with self.assertRaisesRegex(TypeError, "must be float32"):
            dvdx.State(positions, velocities.astype(np.float64))

    def test_memory_that_cannot_be_stepped_is_refused(self):
        positions, velocities = lattice(4)
        with self.assertRaisesRegex(ValueError, r"\(n, 3\)"):
            dvdx.State(positions.T, velocities.T)
        with self.assertRaisesRegex(ValueError, "one number a particle"):
            dvdx.State(positions, velocities[:3])
        with self.assertRaisesRegex(ValueError, "share memory"):
            dvdx.State(positions, positions)
        with self.assertRaisesRegex(ValueError, "share memory"):
            dvdx.State(np.lib.stride_tricks.as_strided(positions, (4, 3), (0, 4)), velocities)
        frozen = positions.copy()
        frozen.flags.writeable = False
        with self.assertRaisesRegex(ValueError, "read-only"):
            dvdx.State(frozen, velocities)
        crooked = np.frombuffer(bytearray(4 * 12 + 1), np.float32, offset=1).reshape(4, 3)
        with self.assertRaisesRegex(ValueError, "aligned"):
            dvdx.State(crooked, velocities)

    def test_errors_are_pythons_own(self):
        state = dvdx.State(*lattice(3))
        plan = dvdx.compile(swept_sheet(), dvdx.State(*lattice(20)))
        misuses = [
            (ValueError, "steps is -1", lambda: plan.step(state, -1)),
            (TypeError, "integer", lambda: plan.step(state, 1.5)),
            (ValueError, "every is 0", lambda: plan.record(state, 1, every=0)),
            (TypeError, "missing.*'acceleration'", lambda: dvdx.Scene().constant()),
            (ValueError, "rows: .*negative", lambda: dvdx.Scene().grid(rows=-2, columns=2, edge_u=(1, 0, 0), edge_v=(0, 1, 0))),
            (ValueError, "out of its range", lambda: plan.set_mass(-1, 1)),
            (ValueError, "as many particles|count", lambda: plan.step(state)),
            (TypeError, "another type", lambda: plan.step(dvdx.State(*lattice(20, np.float64)))),
            (ValueError, "step is nan", lambda: plan.set_step(float("nan"))),
            (ValueError, "threads is -2", lambda: plan.step(state, threads=-2)),
        ]
        for kind, words, misuse in misuses:
            with self.subTest(words), self.assertRaisesRegex(kind, words):
                misuse()
        self.assertTrue(issubclass(dvdx.DvdxError, Exception))

    def test_a_state_of_another_kind_than_the_plans_is_refused(self):
        scene = dvdx.Scene(mass=[1, 2, 3])
        scene.spring(stiffness=1)
        plan = dvdx.compile(scene, dvdx.State(*lattice(3)))
        with self.assertRaises(dvdx.DvdxError):
            plan.step(dvdx.State(*lattice(4)))
        with self.assertRaisesRegex(dvdx.DvdxError, "type"):
            plan.step(dvdx.State(*lattice(3, np.float64)))
        for time, words in ((float("nan"), "nan"), (float("-inf"), "-inf")):
            for act in (plan.step, plan.seek):
                with self.assertRaisesRegex(dvdx.DvdxError, f"state.clock is {words}: must be a finite time"):
                    act(dvdx.State(*lattice(3), time=time), 1)


class Plans(unittest.TestCase):
    def test_a_mesh_holds_what_falls_on_it(self):
        state = dvdx.State(np.array([[0.1, 0.5, 0.2]]), np.zeros((1, 3)))
        scene = dvdx.Scene()
        scene.constant(acceleration=(0, -9.81, 0))
        corners = [[-2, 0, -1], [2, 0, -1], [0, 0, 2], [0, -2, 0]]
        scene.mesh(vertices=corners, triangles=[[0, 2, 1], [2, 0, 3], [1, 2, 3], [0, 1, 3]], cell=0.1, friction=0.5)
        dvdx.compile(scene, state, step=1 / 64).step(state, 128)
        for axis, place in zip("xyz", (0.1, 0, 0.2)):
            np.testing.assert_allclose(state.arrays[axis], [place], rtol=0, atol=1e-12)
        with self.assertRaisesRegex(dvdx.DvdxError, "only one triangle"):
            scene = dvdx.Scene()
            scene.mesh(vertices=corners, triangles=[[0, 2, 1]])
            dvdx.compile(scene, state)

    def test_seek_is_where_steps_lead(self):
        def swinging():
            state = dvdx.State(*lattice(9, np.float64))
            scene = dvdx.Scene()
            scene.spring(stiffness=4, damping=0.1)
            return state, dvdx.compile(scene, state, step=1 / 64)

        stepped, plan = swinging()
        plan.step(stepped, 640)
        sought, plan = swinging()
        plan.seek(sought, 640)
        np.testing.assert_allclose(sought.arrays["x"], stepped.arrays["x"], rtol=0, atol=1e-12)
        self.assertEqual((stepped.time, sought.time), (10, 10))

    def test_set_step_changes_the_step(self):
        state = dvdx.State(*lattice(2, np.float64))
        plan = dvdx.compile(dvdx.Scene(), state, step=0.5)
        plan.set_step(0.25)
        plan.step(state)
        self.assertEqual((plan.step_size, state.time), (0.25, 0.25))
        with self.assertRaises(dvdx.DvdxError):
            plan.set_step(float("nan"))

    def test_a_plan_is_changed_while_it_runs(self):
        def hanging(stiffness, mass, fixed):
            scene = dvdx.Scene(mass=mass, fixed=fixed)
            scene.constant(acceleration=(0, -9.81, 0))
            scene.plane(normal=(0, 1, 0), offset=-100)
            scene.springs(pairs=[(0, 1), (1, 2), (2, 3)], stiffness=stiffness)
            return scene

        changed, wanted = dvdx.State(*lattice(4)), dvdx.State(*lattice(4))
        plan = dvdx.compile(hanging(40, 1, [0]), changed)
        plan.set_springs_stiffness([30, 20, 10])
        plan.set_mass(2, 1.5)
        plan.fix(3)
        plan.release(0)
        plan.set_contact(0, hanging(1, 1, []))
        anew = dvdx.compile(hanging([30, 20, 10], [1, 1, 1.5, 1], [3]), wanted)
        plan.step(changed, 5)
        anew.step(wanted, 5)
        np.testing.assert_array_equal(changed.arrays["x"], wanted.arrays["x"])
        plan.break_spring(1, 2)
        with self.assertRaisesRegex(dvdx.DvdxError, "broken"):
            plan.break_spring(2, 1)
        changed.arrays["x"][3] += 90
        self.assertEqual(plan.tear(changed, 1.5), 1)
        self.assertEqual(plan.tear(changed, 1.5), 0)
        with self.assertRaisesRegex(dvdx.DvdxError, "stretch"):
            plan.tear(changed, 1)
        with self.assertRaises(dvdx.DvdxError):
            plan.set_grid_stiffness(structural=1)

    def test_clones_and_workspaces_step_states_of_their_own_on_threads(self):
        def thrown(speed):
            positions = np.array([(c / 4, 0, r / 3) for r in range(4) for c in range(5)])
            velocities = np.zeros_like(positions)
            velocities[:, 1] = speed
            return dvdx.State(positions, velocities)

        def compiled(state):
            return dvdx.compile(swept_sheet(), state, step=1 / 60)

        plan = compiled(thrown(0))
        clone, workspace = plan.clone(), plan.workspace()
        self.assertGreater(workspace.bytes, 6 * 8 * 20)
        self.assertEqual(dvdx.compile(dvdx.Scene(), thrown(0)).workspace().bytes, 0)
        states = [thrown(speed) for speed in range(3)]
        steps = [(plan, {}), (clone, {}), (plan, {"workspace": workspace})]
        workers = [
            threading.Thread(target=of.step, args=(state, 200), kwargs=how) for state, (of, how) in zip(states, steps)
        ]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        for speed, state in enumerate(states):
            alone = thrown(speed)
            compiled(thrown(0)).step(alone, 200)
            self.assertEqual((state.hash(), state.clock), (alone.hash(), alone.clock))
        plan.set_step(1 / 90)
        self.assertEqual((plan.step_size, clone.step_size), (1 / 90, 1 / 60))
        del plan
        gc.collect()
        clone.step(states[0])
        report = dvdx.ContactReport(0)
        clone.step(states[2], contacts=report, workspace=workspace)
        with self.assertRaisesRegex(dvdx.DvdxError, "another number of contacts"):
            clone.step(states[2], contacts=dvdx.ContactReport(1), workspace=workspace)
        single = dvdx.State(*(column.astype(np.float32) for column in thrown(0).arrays.values()))
        with self.assertRaisesRegex(dvdx.DvdxError, "workspace"):
            compiled(single).step(single, workspace=workspace)

    def test_what_a_plan_carries_on_goes_on_in_another(self):
        def start():
            positions = np.array([(c / 4, 0.01 * c * r, r / 3) for r in range(4) for c in range(5)])
            return dvdx.State(positions, np.zeros_like(positions))

        def compiled():
            return dvdx.compile(swept_sheet(), start(), step=1 / 60)

        def stored(state):
            return dvdx.State(*(column.copy() for column in state.arrays.values()), time=state.clock)

        whole = start()
        compiled().step(whole, 16)
        for is_own in (True, False):
            with self.subTest(is_own=is_own):
                plan, state = compiled(), start()
                how = {} if is_own else {"workspace": plan.workspace()}
                plan.step(state, 7, **how)
                carried = plan.carried(state, **how)
                self.assertEqual(carried.shape, (1 + 3 * 20,))
                other, bare = stored(state), stored(state)
                following = compiled()
                how = {} if is_own else {"workspace": following.workspace()}
                following.restore(carried, other, **how)
                following.step(other, 9, **how)
                self.assertEqual((other.hash(), other.clock), (whole.hash(), whole.clock))
                compiled().step(bare, 9)  # without what was carried
                self.assertNotEqual(bare.hash(), whole.hash())
                with self.assertRaisesRegex(dvdx.DvdxError, "carried is 60 numbers"):
                    following.restore(carried[1:], other, **how)
        self.assertEqual(len(dvdx.compile(rich_scene(), dvdx.State(*lattice(3))).carried(dvdx.State(*lattice(3)))), 0)

    def test_motions_carry_particles_and_contacts(self):
        positions, velocities = np.zeros((2, 3)), np.zeros((2, 3))
        scene = dvdx.Scene()
        scene.motion(keys=[(0, 0, 0, 0, 0, 0, 0), (2, 4, 0, 0, 0, 0, 0)])
        scene.kinematic(particles=[1], motion=0)
        scene.plane(normal=(0, 1, 0), offset=-1)
        scene.contact_motion(0, 0)
        state = dvdx.State(positions, velocities)
        plan = dvdx.compile(scene, state, step=0.25)
        plan.step(state, 2)
        np.testing.assert_allclose(positions[1], (1, 0, 0), atol=1e-15)
        np.testing.assert_allclose(velocities[1], (2, 0, 0), atol=1e-15)
        plan.set_pose(0, translation=(1, 2, 0))
        plan.step(state)
        np.testing.assert_array_equal(positions[1], (1, 2, 0))
        self.assertEqual(positions[0, 1], 1)  # the plane has lifted it
        plan.set_places(0, [(5, 6, 7)])
        plan.step(state)
        np.testing.assert_array_equal(positions[1], (5, 6, 7))
        plan.set_places(0, [(50, 6, 7)], jump=True)
        plan.step(state)
        np.testing.assert_array_equal((positions[1], velocities[1]), ((50, 6, 7), (0, 0, 0)))
        plan.set_places(0, [(5, 6, 7)], jump=True)
        workspace = plan.workspace()
        workspace.set_pose(0, translation=(3, 0, 0))
        workspace.set_places(0, [(8, 9, 10)])
        plan.step(state)  # in the plan's own
        np.testing.assert_array_equal(positions[1], (5, 6, 7))
        plan.step(state, workspace=workspace)
        np.testing.assert_array_equal(positions[1], (8, 9, 10))
        workspace.forget()
        with self.assertRaises(dvdx.DvdxError):
            plan.set_pose(3)
        with self.assertRaises(ValueError):
            plan.set_places(0, [1, 2, 3])

    def test_a_teleport_carries_what_keys_move(self):
        scene = swept_sheet()
        scene.motion(keys=[(0, 0, 0, 0, 0, 0, 0), (1, 1, 0, 0, 0, 0, 0)])
        scene.kinematic(particles=[2], motion=0)
        rows, columns = np.mgrid[0:4, 0:5].reshape(2, -1)
        x = np.stack([columns / 4, 0 * rows, rows / 3], 1)
        states = [dvdx.State(x.copy(), np.zeros_like(x)) for _ in range(3)]
        plan = dvdx.compile(scene, states[0], step=0.01)
        other = plan.clone()
        workspace = plan.workspace()
        for steps in (10, 10):
            plan.step(states[0], steps)
            other.step(states[1], steps)
            plan.step(states[2], steps, workspace=workspace)
            if states[1].arrays["x"][2] < 50:
                other.teleport(states[1], (100, 0, 0), (0, np.pi, 0))
                plan.teleport(states[2], (100, 0, 0), (0, np.pi, 0), workspace=workspace)
        for state in states[1:]:
            np.testing.assert_allclose(state.arrays["x"], 100 - states[0].arrays["x"], atol=1e-9)
            np.testing.assert_allclose(state.arrays["y"], states[0].arrays["y"], atol=1e-9)
            np.testing.assert_allclose(state.arrays["vz"], -states[0].arrays["vz"], atol=1e-9)
        with self.assertRaisesRegex(dvdx.DvdxError, "by.translation"):
            plan.teleport(states[0], (np.inf, 0, 0))

    def test_live_particles_are_teleported(self):
        x, v = np.zeros((4, 3)), np.zeros((4, 3))
        v[0] = 1, 2, 3
        state = dvdx.LiveState(x, v, count=1)
        dvdx.compile_live(dvdx.Scene(), state).teleport(state, (10, 0, 0), (0, np.pi, 0))
        np.testing.assert_allclose(x, [(10, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0)], atol=1e-14)
        np.testing.assert_allclose(v[0], (-1, 2, -3), atol=1e-14)

    def test_a_hitch_is_cut(self):
        scene = swept_sheet()
        scene.coupling(scheme="leapfrog", most_substeps=4)
        x = np.stack([np.arange(20) % 5 / 4, np.zeros(20), np.arange(20) // 5 / 3], 1)
        state = dvdx.State(x, np.zeros_like(x))
        plan = dvdx.compile(scene, state, step=0.01)
        plan.set_step(0.5)
        self.assertTrue(0.01 < plan.step_size < 0.5)
        self.assertLessEqual(plan.network_limit()["substeps"], 4)

    def test_a_state_is_checked(self):
        scene = dvdx.Scene(mass=2.0)
        scene.springs(pairs=[(1, 0)], stiffness=6.0, rest_length=1.0)
        x, v = np.zeros((2, 3)), np.zeros((2, 3))
        x[1, 0], v[0, 1] = 3, 4
        state = dvdx.State(x, v)
        found = dvdx.compile(scene, state, step=0.01).check(state)
        self.assertEqual((found["stretch"], found["spring"], found["not_finite"]), (3, (0, 1), 0))
        self.assertEqual((found["elastic"], found["kinetic"], found["off"]), (0.5 * 6 * 4, 0.5 * 2 * 16, 0))

    def test_keys_jump(self):
        positions, velocities = np.zeros((1, 3)), np.zeros((1, 3))
        scene = dvdx.Scene()
        scene.motion(keys=[(0, 0, 0, 0, 0, 0, 0), (1, 8, 0, 0, 0, 0, 0), (2, 9, 0, 0, 0, 0, 0)])
        scene.jump(0, 1)
        scene.kinematic(particles=[0], motion=0)
        state = dvdx.State(positions, velocities)
        plan = dvdx.compile(scene, state, step=0.25)
        plan.step(state, 3)
        np.testing.assert_array_equal((positions[0], velocities[0]), ((0, 0, 0), (0, 0, 0)))
        plan.step(state)
        np.testing.assert_array_equal((positions[0], velocities[0]), ((8, 0, 0), (1, 0, 0)))
        with self.assertRaises(dvdx.DvdxError):
            scene.jump(0, 3)

    def test_skins_and_tethers_hold_particles(self):
        positions, velocities = np.array([(0.0, 0, 0), (1, 0, 0), (2, 0, 0)]), np.zeros((3, 3))
        scene = dvdx.Scene(fixed=[0])
        scene.constant(acceleration=(0, -8, 0))
        scene.springs(pairs=[(0, 1), (1, 2)], stiffness=0)
        scene.skin(particles=[1], points=[(1, 0, 0)], at_most=0.25)
        scene.backstop(skin=0, normals=[(0, 1, 0)], offset=0.125, radius=0.5)
        scene.tethers(network=0, stretch=1)
        state = dvdx.State(positions, velocities)
        plan = dvdx.compile(scene, state, step=0.125)
        plan.step(state, 8)
        self.assertGreater(np.linalg.norm(positions[1] - (1, -0.625, 0)), 0.5 - 1e-3)  # on the ball
        self.assertLess(np.linalg.norm(positions[1] - (1, 0, 0)), 0.25 + 1e-3)
        self.assertLess(np.linalg.norm(positions[1]), 1 + 1e-3)  # and on its tether, which has drawn it aside
        self.assertAlmostEqual(np.linalg.norm(positions[2]), 2)
        for _ in range(4):
            plan.set_skin(0, [(1, 1, 0)], normals=[(0, 1, 0)])
            plan.step(state)
        self.assertGreater(np.linalg.norm(positions[1] - (1, 0.375, 0)), 0.5 - 1e-3)
        with self.assertRaises(ValueError):
            plan.set_skin(0, [(1, 1, 0)], normals=[(0, 1, 0), (0, 1, 0)])
        with self.assertRaises(dvdx.DvdxError):
            plan.set_skin(1, [(1, 1, 0)])
        with self.assertRaises(ValueError):
            scene.skin(particles=[1, 2], points=[(1, 1, 0)])
        with self.assertRaises(dvdx.DvdxError):
            scene.skin_motion(5, 0)

    def test_balls_meet_and_groups_that_do_not_pass_through(self):
        for groups, ends in (((0, 0), (0.0, 1.0)), ((0, 1), (1.0, 0.0))):
            positions, velocities = np.array([(0.0, 0, 0), (1, 0, 0)]), np.array([(1.0, 0, 0), (0, 0, 0)])
            scene = dvdx.Scene()
            scene.meet(radius=[0.125, 0.25], restitution=1)
            scene.meet_groups(of=groups, meet=[(0, 0)])
            state = dvdx.State(positions, velocities)
            plan = dvdx.compile(scene, state, step=0.125)
            plan.step(state, 16)
            np.testing.assert_allclose(velocities[:, 0], ends, atol=1e-15)
            self.assertGreater(plan.meetings()["substeps"], 0)
            self.assertEqual(plan.meetings()["stretch_limit"], 0)
        with self.assertRaises(dvdx.DvdxError):
            dvdx.Scene().meet_groups(of=[0, 1], meet=[(0, 1)])
        with self.assertRaises(ValueError):
            scene.meet_groups(of=[0, 70000], meet=[(0, 1)])
        with self.assertRaises(ValueError):
            scene.meet(radius=1, near_at_start="never")
        scene = dvdx.Scene().meet(part_of_cells=1.5)
        with self.assertRaisesRegex(dvdx.DvdxError, r"meet\.part_of_cells is 1\.5: must be a number > 0 and < 1"):
            dvdx.compile(scene, state, step=0.125)

    def test_a_report_tells_what_contacts_do(self):
        positions, velocities = np.array([(1.0, 0, 0), (0, 0.81, 0)]), np.zeros((2, 3))
        scene = dvdx.Scene(mass=2)
        scene.constant(acceleration=(0, -8, 0))
        scene.plane(normal=(0, 1, 0), restitution=0.5)
        state = dvdx.State(positions, velocities)
        plan = dvdx.compile(scene, state, step=0.125)
        report = dvdx.ContactReport(1, events=8)
        plan.step(state, 6, contacts=report)
        (event,) = report.events
        self.assertEqual((event["step"], event["particle"], event["contact"]), (4, 1, 0))
        np.testing.assert_allclose((event["time"], *event["impulse"]), (0.45, 0, -10.8, 0), atol=1e-12)
        (of_plane,) = report.sums
        self.assertEqual(of_plane["hits"], 1)
        np.testing.assert_allclose(of_plane["impulse"], (0, -10.8 - 16 * 0.75, 0), atol=1e-12)
        np.testing.assert_allclose(of_plane["torque_impulse"], (0, 0, -12), atol=1e-12)
        report.clear()
        self.assertEqual((len(report.events), report.lost, report.sums[0]["hits"]), (0, 0, 0))
        with self.assertRaises(dvdx.DvdxError):
            plan.step(state, contacts=dvdx.ContactReport(2))

    def test_normals_and_bounds_for_drawing(self):
        rows, columns = 3, 4
        positions = np.zeros((13, 3))
        positions[1:, 0] = np.tile(np.arange(columns), rows)
        positions[1:, 1] = np.repeat(np.arange(rows), columns)
        state = dvdx.State(positions, np.zeros((13, 3)))
        np.testing.assert_array_equal(dvdx.grid_normals(state, rows, columns, first=1), np.tile((0.0, 0, 1), (rows, columns, 1)))
        normals = dvdx.triangle_normals(state, [(1, 5, 2), (2, 5, 6)])
        np.testing.assert_array_equal(normals[[0, 1, 2, 5, 6]], [(0, 0, 0)] + 4 * [(0, 0, -1)])
        least, most = dvdx.bounds(state)
        np.testing.assert_array_equal((least, most), ((0, 0, 0), (columns - 1, rows - 1, 0)))
        with self.assertRaises(dvdx.DvdxError):
            dvdx.grid_normals(state, rows, columns, first=2)
        with self.assertRaises(dvdx.DvdxError):
            dvdx.triangle_normals(state, [(1, 2, 13)])

    def test_air_blows_on_cloth(self):
        positions = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], np.float64)
        velocities = np.zeros_like(positions)
        scene = dvdx.Scene()
        scene.springs(pairs=[(0, 1), (1, 3)], stiffness=0.0)
        scene.aerodynamics(network=0, density=1.2, drag=1, lift=0.5, triangles=[(0, 3, 1), (0, 3, 2)])
        scene.wind(mean=(0, 5, 0), gusts=[(0, 1, 0, 3, 0.5)])
        plan = dvdx.compile(scene, dvdx.State(positions, velocities), step=0.01)
        plan.step(dvdx.State(positions, velocities))
        self.assertTrue((velocities[:, 1] > 0).all())
        plan.set_wind(mean=(0, -50, 0))
        plan.step(dvdx.State(positions, velocities), 10)
        self.assertTrue((velocities[:, 1] < 0).all())
        plan.set_wind(gusts=[(0, 1, 0, 3, 0.5), (1, 0, 0, 2, 0)])
        with self.assertRaises(dvdx.DvdxError):
            plan.set_wind(mean=(0, float("nan"), 0))

    def test_a_mesh_bends_by_angles(self):
        flat = np.array([(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.5, -1, 0)], float)
        positions, velocities = flat.copy(), np.zeros((4, 3))
        positions[2:, 2] = 0.1
        scene = dvdx.Scene()
        scene.springs(pairs=[(0, 1)], stiffness=0.0)
        scene.bending(network=0, modulus=0.02, triangles=[(0, 1, 2), (1, 0, 3)], flat=flat)
        state = dvdx.State(positions, velocities)
        dvdx.compile(scene, state, step=0.01).step(state)
        # w = x0 + x1 - x2 - x3 = -0.2 z, whose force on each is +-0.02 w.
        np.testing.assert_allclose(velocities[:, 2], 0.01 * 0.004 * np.array([1, 1, -1, -1]), rtol=1e-4)
        for wrong in ({"network": 1}, {"modulus": -1.0}, {"flat": flat[:3]}):
            fields = {"network": 0, "modulus": 0.02, "triangles": [(0, 1, 2), (1, 0, 3)], "flat": flat} | wrong
            with self.assertRaises(dvdx.DvdxError):
                scene.bending(**fields)

    def test_how_a_mesh_bends_is_changed_while_it_runs(self):
        flat = np.array([(0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.5, -1, 0)], float)
        angles = {"network": 0, "triangles": [(0, 1, 2), (1, 0, 3)], "flat": flat}

        def bent(modulus):
            positions = flat.copy()
            positions[2:, 2] = 0.1
            scene = dvdx.Scene()
            scene.springs(pairs=[(0, 1)], stiffness=0.0)
            scene.bending(modulus=modulus, **angles)
            state = dvdx.State(positions, np.zeros((4, 3)))
            return dvdx.compile(scene, state, step=0.01), state

        plan, state = bent(0)
        other, wanted = bent(0.02)
        plan.set_bending(modulus=0.02, **angles)
        plan.step(state, 9)
        other.step(wanted, 9)
        self.assertEqual(state.hash(), wanted.hash())
        with self.assertRaisesRegex(dvdx.DvdxError, "modulus is -1"):
            plan.set_bending(modulus=-1, **angles)
        with self.assertRaisesRegex(dvdx.DvdxError, r"networks\[1\]"):
            plan.set_bending(modulus=1, **(angles | {"network": 1}))
        with self.assertRaisesRegex(TypeError, "bending has no stiffness"):
            plan.set_bending(stiffness=1)
        plan.step(state)
        other.step(wanted)
        self.assertEqual(state.hash(), wanted.hash())

    def test_explain_speaks_of_the_scene(self):
        plan = dvdx.compile(rich_scene(), dvdx.State(*lattice(2)))
        self.assertIn("contact", plan.explain())
        self.assertIsNone(plan.network_limit())

    def test_constraints_hold(self):
        positions = np.array([[0, 0, 0], [1, 0, 0], [5, 5, 5]], np.float64)
        velocities = np.array([[0, 0, 0], [0, 2, 0], [1, 1, 1]], np.float64)
        scene = dvdx.Scene()
        scene.constant(acceleration=(0, -9.81, 0))
        scene.distance(pairs=[(0, 1)], length=1)
        scene.on_point(particle=0, at=(0, 0, 0))
        scene.on_line(particle=2, through=(5, 5, 5), direction=(1, 0, 0))
        state = dvdx.State(positions, velocities)
        dvdx.compile(scene, state, step=1 / 240).step(state, 240)
        self.assertAlmostEqual(np.linalg.norm(positions[1] - positions[0]), 1, delta=1e-6)
        np.testing.assert_allclose(positions[0], 0, atol=1e-9)
        np.testing.assert_allclose(positions[2, 1:], 5, atol=1e-9)

    def test_a_grid_hangs_from_what_is_fixed(self):
        rows, columns = 4, 5
        positions = np.array([[c / 4, -r / 3, 0] for r in range(rows) for c in range(columns)], np.float32)
        start = positions.copy()
        scene = dvdx.Scene(mass=0.01, fixed=[0, columns - 1])
        scene.constant(acceleration=(0, -9.81, 0))
        scene.grid(rows=rows, columns=columns, edge_u=(1, 0, 0), edge_v=(0, -1, 0), structural=40, shear=10, damping=0.01)
        state = dvdx.State(positions, np.zeros_like(positions))
        plan = dvdx.compile(scene, state, step=1 / 60)
        plan.step(state, 30)
        self.assertTrue((positions[[0, columns - 1]] == start[[0, columns - 1]]).all())
        self.assertLess(positions[-1, 1], start[-1, 1])
        self.assertGreater(plan.network_limit()["frequency"], 0)


    def test_what_float32_cannot_hold_is_kept_in_the_rests(self):
        def end(**options):
            positions, velocities = np.full((2, 3), 0.1, np.float32), np.full((2, 3), 0.3, np.float32)
            rests = (np.zeros_like(positions), np.zeros_like(velocities))
            state = dvdx.State(positions, velocities, rests=rests)
            dvdx.compile(dvdx.Scene(origin=(10000, 0, 0)), state, step=1e-3, **options).step(state, 100000)
            return abs(positions.astype(np.float64) + rests[0] - (np.float32(0.1) + 100.0 * np.float32(0.3).item())).max()

        self.assertLess(end(rounding="compensated"), 1e-6)
        self.assertGreater(end(), 1e-4)
        state = dvdx.State(*lattice(2))
        with self.assertRaises(dvdx.DvdxError):
            dvdx.compile(dvdx.Scene(), state, rounding="compensated").step(state)


def fountain(**arrays):
    """A jet of 600 drops a second that live for half a second to a whole one, for at most 1000 drops."""
    positions, velocities, age, lifetime = (np.zeros((1000, 3)), np.zeros((1000, 3)), np.zeros(1000), np.zeros(1000))
    state = dvdx.LiveState(positions, velocities, age=age, lifetime=lifetime, **arrays)
    scene = dvdx.Scene().constant(acceleration=(0, -9.81, 0))
    jet = {"shape": "disc", "at": (0, 1, 0), "normal": (0, 1, 0), "radius": 0.1, "rate": 600, "velocity": (0, 5, 0)}
    jet |= {"spread_box": (0.5, 0.2, 0.5), "least_lifetime": 0.5, "most_lifetime": 1, "seed": 3}
    ground = {"normal": (0, 1, 0), "offset": 0}
    plan = dvdx.compile_live(scene, state, [jet], [ground], inside=((-9, -9, -9), (9, 9, 9)), not_finite="removed", step=1 / 64)
    return state, plan


class Introspection(unittest.TestCase):
    def test_names_versions_and_help_are_there(self):
        self.assertRegex(dvdx.__version__, r"^\d+\.\d+\.\d+$")
        self.assertIn(dvdx.__version__, dvdx.build_info())
        for name in dvdx.__all__:
            self.assertTrue(getattr(dvdx, name).__doc__ or name == "COLUMNS", name)
        self.assertTrue((pathlib.Path(dvdx.__file__).parent / "py.typed").exists())
        help_text = pydoc.plain(pydoc.render_doc(dvdx.Scene))
        self.assertRegex(help_text, r"constant\(self, \*, acceleration: .*method: ")
        self.assertIn("Coulomb", pathlib.Path(dvdx.__file__).read_text())

    def test_every_public_call_has_hints_and_words(self):
        public = [each for each in vars(dvdx).values() if getattr(each, "__module__", "") == "dvdx" and callable(each)]
        calls = [each for each in public if inspect.isfunction(each) and not each.__name__.startswith("_")]
        for kind in (each for each in public if inspect.isclass(each) and each.__name__ in dvdx.__all__):
            calls += [each for name, each in vars(kind).items() if inspect.isfunction(each) and not name.startswith("_")]
        self.assertGreater(len(calls), 60)
        for call in calls:
            with self.subTest(call.__qualname__):
                hints = typing.get_type_hints(call, vars(dvdx))
                self.assertEqual(hints.keys() | {"self"}, inspect.signature(call).parameters.keys() | {"return", "self"})
                self.assertTrue(call.__doc__)

    def test_methods_of_a_scene_have_the_fields_of_the_header(self):
        for kind in dvdx._ADDERS:
            method = getattr(dvdx.Scene, kind.removeprefix("dvdx_"))
            with self.subTest(kind):
                named = inspect.signature(method).parameters.keys() - {"self", "keywords"}
                self.assertTrue(not named or named == dvdx._fields(kind).keys(), named ^ dvdx._fields(kind).keys())

    def test_objects_show_what_they_are(self):
        scene = dvdx.Scene(mass=2).constant(acceleration=(0, -9.81, 0)).plane(normal=(0, 1, 0), restitution=0.4)
        text = "dvdx.Scene(mass=2).constant(acceleration=(0, -9.81, 0)).plane(normal=(0, 1, 0), restitution=0.4)"
        self.assertEqual(repr(scene), text)
        self.assertEqual(repr(eval(text)), text)
        state = dvdx.State(*lattice(3))
        self.assertEqual(repr(state), "<dvdx.State: 3 particles, float32, time 0 s>")
        plan = dvdx.compile(scene, state, step=0.25, isa="reference")
        self.assertEqual(repr(plan), "<dvdx.Plan: constant, plane; float32, step 0.25 s, reference>")
        self.assertEqual(repr(dvdx.ContactReport(2)), "<dvdx.ContactReport: 2 contacts, 0 events, 0 lost>")
        self.assertIn("<array (9, 2)>", repr(dvdx.Scene().springs(pairs=[(i, i + 1) for i in range(9)], stiffness=1)))

    def test_positions_are_the_arrays_that_were_given(self):
        positions, velocities = lattice(6)
        state = dvdx.State(positions, velocities)
        self.assertIs(state.positions.base if state.positions.base is not None else state.positions, positions)
        np.testing.assert_array_equal(state.velocities, velocities)
        record = np.zeros(6, [("velocity", "f4", 3), ("position", "f4", 3)])
        record["position"] = positions
        self.assertTrue(np.shares_memory(dvdx.State(record).positions, record))
        columns = dvdx.State(*positions.T.copy(), *velocities.T.copy())
        np.testing.assert_array_equal(columns.positions, positions)
        with self.assertRaisesRegex(ValueError, "read-only"):
            columns.positions[0] = 0  # a copy: what is written there would be lost


class Scenes(unittest.TestCase):
    def test_a_plans_scene_is_what_it_steps(self):
        state = dvdx.State(*lattice(4))
        scene = dvdx.Scene(mass=2).springs(pairs=[(0, 1), (1, 2)], stiffness=3).constant(acceleration=(0, -1, 0))
        plan = dvdx.compile(scene, state)
        plan.set_springs_stiffness([7, 9])
        plan.set_force(0, dvdx.Scene().constant(acceleration=(0, -5, 0)))
        scene.constant(acceleration=(100, 0, 0))  # too late for the plan
        again, other = dvdx.State(*lattice(4)), dvdx.compile(plan.scene, state)
        plan.step(state, 5)
        other.step(again, 5)
        self.assertEqual(state.hash(), again.hash())
        self.assertEqual((plan.scene.step, other.step_size), (1 / 60, 1 / 60))
        self.assertIn("constant(acceleration=(0, -5, 0))", repr(plan.scene))

    def test_old_names_warn_and_do_the_same(self):
        def stepped(change):
            state = dvdx.State(*lattice(4))
            plan = dvdx.compile(dvdx.Scene().constant(acceleration=(0, -9, 0)).plane(normal=(0, 1, 0)), state)
            change(plan)
            plan.step(state, 9)
            return state.hash()

        other = dvdx.Scene().constant(acceleration=(1, 0, 0)).plane(normal=(0, 1, 0), offset=1)
        with self.assertWarns(DeprecationWarning):
            old = stepped(lambda plan: (plan.replace(0, other), plan.replace_contact(0, other)))
        self.assertEqual(old, stepped(lambda plan: (plan.set_force(0, other), plan.set_contact(0, other))))

    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_a_loaded_scene_has_the_bits_of_the_command(self):
        scenes = ("two-springs", "bouncing", "net-stiff", "rope-bridge", "seed-pair", "cape", "rail", "flag-in-wind", "cradle",
                  "avalanche", "torus", "shirt", "curtain")  # fmt: skip
        for name in scenes:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                file = json.loads((ROOT / f"tools/scenes/{name}.json").read_text())
                file["duration"] = 4 * file["step"]
                for mesh in (ROOT / "tools/scenes").glob("*.obj"):
                    pathlib.Path(folder, mesh.name).write_bytes(mesh.read_bytes())
                path = pathlib.Path(folder, "scene.json")
                path.write_text(json.dumps(file))
                scene = dvdx.Scene.load(path)
                state = scene.state(np.float64)
                dvdx.compile(scene, state).step(state, 4)
                hash_of_command, steps = run(file, "float64", folder)
                self.assertEqual((steps, scene.duration), (4, file["duration"]))
                self.assertEqual(state.hash(), hash_of_command)

    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_springs_that_tear_and_particles_that_come_and_go_have_the_bits_of_the_command(self):
        for name, steps in (("tear", 300), ("fountain", 30), ("fireworks", 40)):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                file = json.loads((ROOT / f"tools/scenes/{name}.json").read_text())
                file["duration"] = steps * file["step"]
                path = pathlib.Path(folder, "scene.json")
                path.write_text(json.dumps(file))
                scene = dvdx.Scene.load(path)
                if name == "tear":
                    state = scene.state(np.float64)
                    self.assertGreater(dvdx.compile(scene, state).run(state, steps), 0)
                else:
                    state = scene.live_state(np.float64)
                    dvdx.compile_live(scene, state).step(state, steps)
                    self.assertGreater(state.born, 0)
                self.assertEqual((state.hash(), steps), run(file, "float64"))

    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_meshes_are_welded_limited_and_bent_as_by_the_command(self):
        obj = "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nv 1 0 0.00001\nv 2 0 0\nv 2 1 0\nv 9 9 9\nv 1 1 0.1\n"
        obj += "f 1 2 \\\n3 4\nf 5/1/1 -4// 7 -1\nl 1 3\n"
        network = {"type": "mesh", "file": "two.obj", "mass": 0.7, "edge": 90, "bend": 2, "bending": 0.01, "weld": 1e-4,
                   "unreferenced": "leave_out", "fixed": [0, 3], "strain_limit": 0.03, "damping": 0.1,
                   "aerodynamics": {"drag": 0.8}}  # fmt: skip
        grid = {"type": "grid", "rows": 3, "columns": 4, "origin": [0, 0, 2], "edge_u": [1, 0.1, 0], "edge_v": [0, 0.2, 1],
                "mass": 0.5, "structural": 40, "strain_limit": 0.05, "fixed": "edge_top"}  # fmt: skip
        file = {"format": "dvdx-scene/1", "name": "two", "step": 0.01, "duration": 0.1, "network": [network, grid],
                "particles": {"velocity": {"uniform": {"min": [0, 0, 0], "max": [1, 1, 1], "seed": 4}}},
                "constraints": [{"type": "distance", "pairs": [[6, 12]], "length": "start", "bound": "at_most"}],
                "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]}  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "two.obj").write_text(obj)
            path = pathlib.Path(folder, "scene.json")
            path.write_text(json.dumps(file))
            scene = dvdx.Scene.load(path)
            state = scene.state()
            self.assertEqual(len(state), 6 + 12)
            dvdx.compile(scene, state).step(state, 10)
            self.assertEqual((state.hash(), 10), run(file, "float64", folder))

    def test_what_is_not_read_is_named(self):
        self.assertIn("faces(choice='never')", repr(dvdx.Scene().faces("never")))
        network = {"type": "springs", "pairs": [[0, 1]], "stiffness": 1, "rest_length": 1}
        file = {"format": "dvdx-scene/1", "step": 1, "duration": 1, "particles": {"count": 2}}
        torn = {"network": {**network, "broken": [[0, 1]]}}
        wrong = ((torn, "what is torn"), ({"faces": "some"}, "must be one of"), ({"odd": 1}, "odd"))
        for more, words in wrong:
            with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(ValueError, words):
                path = pathlib.Path(folder, "scene.json")
                path.write_text(json.dumps(file | more))
                dvdx.Scene.load(path)
        with tempfile.TemporaryDirectory() as folder:
            for text, words in (("v 1 2\n", "line 1"), ("v 0 0 0\nf 1 1 1\n", "twice"), ("f 1 2 3\n", "vertex 3"),
                                ("v 0 0 nan\n", "finite"), ("v 0 0 0\nl 1\n", "a line"), ("v 0 0 0\nl -2 1\n", "-2")):  # fmt: skip
                pathlib.Path(folder, "bad.obj").write_text(text)
                path = pathlib.Path(folder, "scene.json")
                path.write_text(json.dumps(file | {"network": {"type": "mesh", "file": "bad.obj", "mass": 1}}))
                with self.assertRaisesRegex(ValueError, words):
                    dvdx.Scene.load(path)
        with self.assertRaisesRegex(ValueError, "was not loaded"):
            dvdx.Scene().state()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "scene.json")
            for text, words in (("{", "scene.json"), ("{}", "dvdx-scene/1"), ('{"format": "dvdx-scene/1"}', "count is missing")):
                path.write_text(text)
                with self.assertRaisesRegex(ValueError, words):
                    dvdx.Scene.load(path)


class ManyInstances(unittest.TestCase):
    def test_they_step_at_once_as_each_by_itself(self):
        def made(count):
            states = [dvdx.State(*lattice(4)) for _ in range(count)]
            scene = dvdx.Scene(mass=2).springs(pairs=[(0, 1), (1, 2)], stiffness=3).constant(acceleration=(0, -1, 0))
            plan = dvdx.compile(scene, states[0])
            return states, [plan.instance(state) for state in states]

        one, alone = made(3)
        two, together = made(3)
        for n, length in enumerate((1 / 60, 1 / 50)):
            for instance in alone:
                instance.step(length)
            dvdx.step_all(together, length if n else [length] * 3, threads=2)
        self.assertEqual([state.hash() for state in one], [state.hash() for state in two])
        self.assertEqual([state.time for state in one], [state.time for state in two])
        with self.assertRaisesRegex(ValueError, "frame_times"):
            dvdx.step_all(together, [0.1, 0.2])
        with self.assertRaisesRegex(ValueError, "instances.1. is listed before"):
            dvdx.step_all([together[0], together[0]], 0.1)

    def test_the_number_of_what_was_added_last(self):
        scene = dvdx.Scene()
        with self.assertRaises(IndexError):
            scene.last
        self.assertEqual(scene.constant(acceleration=(0, 0, 0)).last, 0)
        self.assertEqual(scene.plane(normal=(0, 1, 0)).last, 0)
        self.assertEqual(scene.drag(coefficient=1).last, 1)
        self.assertEqual(scene.sphere(center=(0, 0, 0), radius=1).last, 1)
        self.assertEqual(scene.motion().last, 0)


class Threads(unittest.TestCase):
    def test_a_network_has_the_same_bits_on_any_number_of_threads(self):
        def stepped(threads):
            rows, columns = 40, 50
            positions = np.array([(c / 50, 0.01 * (r * c % 7), r / 40) for r in range(rows) for c in range(columns)])
            scene = dvdx.Scene(mass=0.01, fixed=[0, 49]).constant(acceleration=(0, -9.81, 0))
            scene.grid(rows=rows, columns=columns, edge_u=(1, 0, 0), edge_v=(0, 0, 1), structural=40, shear=10)
            state = dvdx.State(positions, np.zeros_like(positions))
            dvdx.compile(scene, state).step(state, 5, threads=threads)
            return state.hash()

        alone = stepped(None)
        for threads in (1, 3, dvdx.Threads(2)):
            self.assertEqual(stepped(threads), alone)
        self.assertEqual(dvdx.Threads(3).count, 3)
        self.assertGreaterEqual(dvdx.Threads().count, 1)


def recorded():
    positions = np.array([(c / 4, 1, r / 3) for r in range(4) for c in range(5)])
    state = dvdx.State(positions, np.zeros_like(positions))
    scene = swept_sheet().sphere(center=(0.5, 0.3, 0.5), radius=0.3)
    return dvdx.compile(scene, state, step=1 / 60).record(state, steps=20, every=4), state


class Recordings(unittest.TestCase):
    def test_states_are_those_of_steps(self):
        recording, end = recorded()
        self.assertEqual(repr(recording), "<dvdx.Recording: 6 states of 20 particles, 0 to 0.333333 s>")
        again = dvdx.State(recording.positions[0].copy(), recording.velocities[0].copy())
        plan = dvdx.compile(swept_sheet().sphere(center=(0.5, 0.3, 0.5), radius=0.3), again, step=1 / 60)
        for k in range(1, 6):
            plan.step(again, 4)
            np.testing.assert_array_equal(recording.positions[k], again.positions)
            np.testing.assert_array_equal(recording.velocities[k], again.velocities)
            self.assertEqual((recording.times[k], recording.energy[k]), (again.time, plan.energy(again).total))
        self.assertEqual(again.hash(), end.hash())
        falling = dvdx.State(np.array([(0.0, 2, 0)]), np.array([(3.0, 4, 0)]))
        energy = dvdx.compile(dvdx.Scene(mass=2).constant(acceleration=(0, -10, 0)), falling).energy(falling)
        self.assertEqual((energy.kinetic, energy.elastic, energy.weight, energy.total), (25, 0, 40, 65))

    def test_files_of_numbers_hold_the_states(self):
        recording, _ = recorded()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "cloth.npz")
            recording.save(path)
            with np.load(path) as stored:
                np.testing.assert_array_equal(stored["positions"], recording.positions)
                np.testing.assert_array_equal(stored["steps"], [0, 4, 8, 12, 16, 20])
            recording.save(os.path.join(folder, "cloth.pc2"))
            cache = pathlib.Path(folder, "cloth.pc2").read_bytes()
            self.assertEqual(struct.unpack("<12siiffi", cache[:32]), (b"POINTCACHE2\0", 1, 20, 0, 1, 6))
            np.testing.assert_array_equal(np.frombuffer(cache[32:], "<f4").reshape(6, 20, 3), recording.positions.astype("f4"))
            lines = pathlib.Path(folder, "cloth.obj").read_text().splitlines()
            self.assertEqual([sum(line.startswith(mark) for line in lines) for mark in ("v ", "f ")], [20, 12])
            self.assertIn("f 1 2 7 6", lines)
            with self.assertRaisesRegex(ValueError, "cloth.gif: must end in one of .npz, .pc2"):
                recording.save(os.path.join(folder, "cloth.gif"))

    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_pages_and_pictures_are_the_commands(self):
        recording, _ = recorded()
        with tempfile.TemporaryDirectory() as folder:
            for name, mark in (("cloth.png", b"\x89PNG"), ("cloth.apng", b"\x89PNG"), ("cloth.html", b"<!")):
                path = pathlib.Path(folder, name)
                try:
                    recording.save(path)
                except RuntimeError as fault:  # npm, which builds the page, is not everywhere
                    self.assertIn("the playback page has not been built", str(fault))
                    self.assertEqual(path.suffix, ".html")
                else:
                    self.assertTrue(path.read_bytes().startswith(mark), name)

    def test_without_a_command_there_is_a_clear_error(self):
        recording, _ = recorded()
        environment = {"PATH": "", "DVDX_COMMAND": ""}
        with unittest.mock.patch.dict(os.environ, environment), unittest.mock.patch.object(dvdx, "_folder", pathlib.Path("/none")):
            with self.assertRaisesRegex(RuntimeError, "no dvdx command"):
                recording.save("cloth.png")


class Turnover(unittest.TestCase):
    def test_particles_come_and_go_in_the_arrays_themselves(self):
        state, plan = fountain()
        plan.step(state, 16)
        self.assertEqual((len(state), state.born, state.removed, state.time), (150, 150, 0, 0.25))
        plan.step(state, 112)
        self.assertEqual(state.born, 1200)
        self.assertEqual(len(state), state.born - state.removed)
        live = slice(0, len(state))
        self.assertTrue((state.arrays["age"][live] < state.arrays["lifetime"][live]).all())
        self.assertTrue((np.diff(state.arrays["age"][live]) < 0).all())  # in the order of their births
        self.assertTrue((state.arrays["y"][live] >= 0).all())
        self.assertEqual(state.dropped, 0)
        self.assertIn("1 emitter", plan.explain())

    def test_without_order_the_last_fills_the_hole(self):
        state, _ = fountain(count=9, carried=(np.arange(1000),))
        plan = dvdx.compile_live(dvdx.Scene(), state, order="any")
        state.arrays["age"][[2, 7]] = np.inf
        state.arrays["lifetime"][:] = 1
        plan.remove(state)
        self.assertEqual(state.carried[0][: len(state)].tolist(), [0, 1, 8, 3, 4, 5, 6])
        self.assertIn("births take the places of what goes", plan.explain())
        with self.assertRaisesRegex(ValueError, "order: 'first': must be one of kept, any"):
            dvdx.compile_live(dvdx.Scene(), state, order="first")

    def test_columns_of_any_kind_go_along(self):
        names = np.zeros(1000, "S5")
        numbers = np.zeros((1000, 2), np.uint16)[:, 1]
        state, plan = fountain(carried=(names, numbers))
        plan.step(state, 8)
        names[: len(state)], numbers[: len(state)] = b"first", np.arange(len(state))
        state.arrays["age"][10] = np.inf
        plan.remove(state)
        self.assertEqual((len(state), state.removed), (74, 1))
        self.assertEqual((numbers[9], numbers[10], names[73]), (9, 11, b"first"))
        plan.step(state)
        self.assertEqual(names[len(state) - 1], b"")

    def test_what_cannot_come_and_go_is_refused(self):
        state, _ = fountain()
        scene = dvdx.Scene()
        with self.assertRaisesRegex(ValueError, "emitter 0: shape: 'ring': must be one of point, disc, box"):
            dvdx.compile_live(scene, state, [{"shape": "ring"}])
        with self.assertRaisesRegex(dvdx.DvdxError, r"emitters\[0\].rate is -1"):
            dvdx.compile_live(scene, state, [{"rate": -1}])
        with self.assertRaisesRegex(ValueError, "inside: 3 numbers: must be 6"):
            dvdx.compile_live(scene, state, inside=(1, 2, 3))
        with self.assertRaisesRegex(ValueError, "age is of shape"):
            dvdx.LiveState(*lattice(4), age=np.zeros(3, np.float32))
        with self.assertRaisesRegex(ValueError, "count 5: must be from 0 to 4"):
            dvdx.LiveState(*lattice(4), count=5)
        with self.assertRaisesRegex(TypeError, "objects"):
            dvdx.LiveState(*lattice(4), carried=[np.empty(4, object)])


    def test_bodies_and_nozzles_follow_motions_and_workspaces_have_states_of_their_own(self):
        scene = dvdx.Scene().motion().sphere(center=(0, 1, 0), radius=0.4)
        scene.contact_motion(scene.last, 0)
        jet = {"shape": "point", "at": (0, 3, 0), "rate": 600, "velocity": (0, -2, 0), "motion": 0}
        empty = lambda: dvdx.LiveState(np.zeros((1000, 3)), np.zeros((1000, 3)))  # noqa: E731
        one, two = empty(), empty()
        plan = dvdx.compile_live(scene, one, [jet], step=1 / 60)
        workspace = plan.workspace()
        self.assertGreater(workspace.bytes, 0)
        for n in range(1, 61):
            plan.set_pose(0, (0.02 * n, 0, 0), (0, 0.01 * n, 0), jump=n == 30)
            workspace.set_pose(0, (0.02 * n, 0, 0), (0, 0.01 * n, 0), jump=n == 30)
            plan.step(one)
            plan.step(two, workspace=workspace)
        plan.burst(one, 10)
        plan.burst(two, 10, workspace=workspace)
        plan.teleport(one, (5, 0, 0))
        plan.teleport(two, (5, 0, 0), workspace=workspace)
        plan.step(one)
        plan.step(two, workspace=workspace)
        self.assertEqual((one.hash(), one.born), (two.hash(), 620))
        from_ball = one.positions[: len(one)] - (6.2, 1, 0)
        self.assertGreater(np.linalg.norm(from_ball, axis=1).min(), 0.39)
        self.assertEqual(plan.check(one)["not_finite"], 0)
        plan.set_wind((1, 0, 0))
        plan.set_pose(0, (0, 0, 0))
        with self.assertRaisesRegex(dvdx.DvdxError, "tell the workspace"):
            plan.step(two, workspace=dvdx.compile_live(scene, two, [jet]).workspace())
        with self.assertRaisesRegex(ValueError, "motions.4"):
            plan.set_pose(4)
        with self.assertRaisesRegex(ValueError, "motion"):
            dvdx.compile_live(scene, one, [{**jet, "motion": -1}])
        self.assertIn("LifecyclePlan: step 0.0166", repr(plan))

    def test_a_live_plan_is_changed_while_it_runs(self):
        state, plan = fountain()
        plan.set_step(1 / 32)
        plan.step(state, 8)
        self.assertEqual((state.born, state.time), (150, 0.25))
        plan.burst(state, 40)
        self.assertEqual((state.born, len(state)), (190, 190))
        self.assertEqual(state.arrays["age"][150:190].tolist(), [0.0] * 40)
        other = plan.clone()
        other.set_emitter(0, {"shape": "point", "at": (5, 1, 0), "rate": 0, "seed": 3})
        other.step(state, 4)
        self.assertEqual(state.born, 190)
        other.set_emitter(0, {"shape": "point", "at": (5, 1, 0), "rate": 320, "seed": 4})
        other.set_force(0, dvdx.Scene().constant(acceleration=(0, 0, 0)))
        other.step(state, 1)
        self.assertEqual(state.born, 200)
        self.assertTrue((state.arrays["x"][len(state) - 10 : len(state)] == 5).all())
        with self.assertRaisesRegex(ValueError, "below 1"):
            plan.burst(state, 1, emitter=1)
        with self.assertRaisesRegex(ValueError, "step is 0"):
            plan.set_step(0)
        with self.assertRaisesRegex(ValueError, r"contacts\[0\]"):
            plan.set_contact(0, dvdx.Scene().plane(normal=(0, 1, 0)))


class Instances(unittest.TestCase):
    def hanging(self):
        positions = np.array([(c / 4, 0, r / 3) for r in range(4) for c in range(5)])
        scene = dvdx.Scene(mass=0.01).constant(acceleration=(0, -9.81, 0))
        scene.grid(rows=4, columns=5, edge_u=(1, 0, 0), edge_v=(0, 0, 1), structural=40, shear=10, damping=0.01)
        scene.motion().kinematic(particles=range(5)).motion().sphere(center=(0.5, -0.4, 0.5), radius=0.2).contact_motion(0, 1)
        state = dvdx.State(positions, np.zeros_like(positions))
        return dvdx.compile(scene, state), state

    def test_an_instance_has_the_bits_of_a_plan_of_its_own(self):
        plan, state = self.hanging()
        own, other = self.hanging()
        instance = plan.instance(state)
        for k in range(6):
            step, pins = (1 / 60, 1 / 45)[k % 2], other.positions[:5] + (0, 0.01 * k, 0)
            instance.move_pins(0, pins)
            instance.move_body(1, translation=(0, 0.1 * k, 0))
            instance.step(step)
            own.set_places(0, pins)
            own.set_pose(1, translation=(0, 0.1 * k, 0))
            own.set_step(step)
            own.step(other)
            self.assertEqual((state.hash(), state.clock), (other.hash(), other.clock))
        self.assertIn("20 particles", repr(instance))
        self.assertEqual(instance.check(), own.check(other))

    def test_an_instance_is_carried_blown_and_played(self):
        plan, state = self.hanging()
        instance = plan.instance(state)
        instance.teleport(translation=(50, 0, 0))
        frames = [positions.copy() for positions in instance.play(seconds=0.5, fps=40)]
        self.assertEqual(len(frames), 20)
        self.assertLess(np.abs(frames[-1][:, 0] - 50.5).max(), 0.7)
        self.assertGreater(np.abs(frames[-1] - frames[0]).max(), 0.01)
        self.assertEqual(instance.advance(1.0, most=3), 3)
        with self.assertRaisesRegex(ValueError, "frame_time"):
            instance.advance(-1)
        with self.assertRaisesRegex(ValueError, r"motions\[9\]"):
            instance.move_body(9)
        with self.assertRaisesRegex(ValueError, "places is 2 points"):
            instance.move_pins(0, np.zeros((2, 3)))
        workspace = plan.workspace()
        plan.set_places(0, np.zeros((5, 3)))
        with self.assertRaisesRegex(ValueError, "told where something goes"):
            plan.step(self.hanging()[1], workspace=workspace)


class Readme(unittest.TestCase):
    def test_its_python_runs_as_it_stands(self):
        blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.DOTALL | re.MULTILINE)
        self.assertGreater(len(blocks), 0)
        for block in blocks:
            script = block + "assert np.isfinite(positions).all() and (positions[:, 1] >= -1e-9).all() and np.any(velocities)\n"
            subprocess.run([sys.executable, "-B", "-c", script], check=True)


class Examples(unittest.TestCase):
    def test_a_sheet_falls_on_a_ball(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "cloth.npz")
            subprocess.run([sys.executable, "-B", ROOT / "examples/cloth.py", path], check=True, stdout=subprocess.DEVNULL)
            with np.load(path) as stored:
                self.assertEqual(stored["positions"].shape, (31, 576, 3))


class Command(unittest.TestCase):
    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_a_fault_of_the_command_is_an_error(self):
        with self.assertRaisesRegex(dvdx.DvdxError, "none.json"):
            dvdx.report("none.json")

    @unittest.skipUnless(COMMAND, "DVDX_COMMAND names no command")
    def test_a_report_is_a_dict(self):
        told = dvdx.report(ROOT / "tools/scenes/two-springs.json", quick=True, precision="float64")
        runs = told["scenes"][0]["runs"]
        self.assertIn("combined", {run["method"] for run in runs})
        self.assertEqual({run["precision"] for run in runs}, {"float64"})

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "no matplotlib")
    def test_the_example_draws_a_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            picture = os.path.join(folder, "trajectory.png")
            subprocess.run([sys.executable, "-B", ROOT / "tools/python/plot_trajectory.py", picture], check=True)
            from matplotlib import image

            self.assertGreater(len(np.unique(image.imread(picture).reshape(-1, 4), axis=0)), 20)  # colours


if __name__ == "__main__":
    unittest.main()
