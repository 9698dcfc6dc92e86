"""States that were kept while a plan stepped, and files of them."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
from typing import Any, Dict, List, Tuple, Union

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Items = List[Tuple[str, Dict[str, Any]]]


def command() -> str:
    """The command: the one that DVDX_COMMAND names, else that of the library's prefix, else `dvdx` on PATH."""
    import dvdx

    beside = [str(folder / "bin/dvdx") for folder in dvdx._folder.parents[:2] if (folder / "bin/dvdx").exists()]
    found = os.environ.get("DVDX_COMMAND") or (beside[0] if beside else shutil.which("dvdx"))
    if not found:
        raise RuntimeError("there is no dvdx command on PATH: install it, or name it by DVDX_COMMAND")
    return found


class Recording:
    """States one after the other; made by Plan.record().

    times: s, (k,). positions, velocities: m and m/s, (k, n, 3), in the state's precision. energy: J, (k,), as Plan.energy().
    """

    def __init__(self, particles: int, dtype: Any, states: int, every: int, items: Items) -> None:
        self.every = every
        """Steps from one state to the next."""
        self.times: Array = np.zeros(states)
        self.energy: Array = np.zeros(states)
        self.positions: Array = np.zeros((states, particles, 3), dtype)
        self.velocities: Array = np.zeros((states, particles, 3), dtype)
        self._items = list(items)

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        span = f", {self.times[0]:g} to {self.times[-1]:g} s" if len(self) else ""
        return f"<dvdx.Recording: {len(self)} states of {self.positions.shape[1]} particles{span}>"

    def keep(self, k: int, time: float, positions: Array, velocities: Array, energy: float) -> None:
        """Sets state k."""
        self.times[k], self.energy[k] = time, energy
        self.positions[k], self.velocities[k] = positions, velocities

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes what the name's end says.

        .npz    NumPy's archive of steps, times, positions, velocities and energy
        .pc2    Blender's mesh cache, and beside it the .obj that it moves
        .html   a page that plays all states, by the command dvdx, which need not be installed for the others
        .apng   a picture that plays them, likewise
        .png    a picture of the last state, likewise

        Pages and pictures show what joins particles, and bodies where the scene has them.
        """
        target = pathlib.Path(path)
        writers = {".npz": self._save_npz, ".pc2": self._save_pc2, ".html": self._draw, ".apng": self._draw, ".png": self._draw}
        if target.suffix not in writers:
            raise ValueError(f"{target.name}: must end in one of {', '.join(writers)}")
        writers[target.suffix](target)

    def _save_npz(self, target: pathlib.Path) -> None:
        steps = self.every * np.arange(len(self), dtype=np.int64)
        with target.open("wb") as out:  # else NumPy would add to the name
            np.savez(
                out, steps=steps, times=self.times, positions=self.positions, velocities=self.velocities, energy=self.energy
            )

    def _save_pc2(self, target: pathlib.Path) -> None:
        # version, points, the first state's frame, frames from one state to the next, states
        header = struct.pack("<12siiffi", b"POINTCACHE2", 1, self.positions.shape[1], 0, 1, len(self))
        target.with_suffix(".obj").write_text(self._mesh(self.positions[0]), encoding="ascii")
        target.write_bytes(header + self.positions.astype("<f4").tobytes())

    def _joined(self) -> Tuple[List[List[int]], List[List[int]]]:
        """Faces of cloth, and lines of what has none, by numbers of particles."""
        faces: List[List[int]] = []
        lines: List[List[int]] = []
        networks: List[Tuple[List[List[int]], List[List[int]]]] = []
        for kind, given in self._items:
            if kind == "grid":
                corners = given.get("first", 0) + np.arange(given["rows"] * given["columns"]).reshape(given["rows"], -1)
                cells = np.stack([corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]], axis=-1)
                networks.append((cells.reshape(-1, 4).tolist(), []))
            elif kind == "springs":
                networks.append(([], np.asarray(given["pairs"]).tolist()))
            elif kind in ("aerodynamics", "bending") and "triangles" in given:
                networks[given.get("network", 0)] = (np.asarray(given["triangles"]).tolist(), [])
            elif kind == "distance":
                lines += np.asarray(given["pairs"]).tolist()
        for own_faces, own_lines in networks:
            faces += own_faces
            lines += own_lines
        return faces, lines

    def _mesh(self, positions: Array) -> str:
        """The particles and what joins them, as an .obj."""
        faces, lines = self._joined()
        points = "".join("v %.9g %.9g %.9g\n" % tuple(point) for point in positions.tolist())
        marked = [("f", face) for face in faces] + [("l", line) for line in lines]
        return points + "".join(f"{mark} {' '.join(str(i + 1) for i in corners)}\n" for mark, corners in marked)

    def _draw(self, target: pathlib.Path) -> None:
        """By the command: a scene whose particles are all driven from state to state, as they were recorded."""
        program = command()
        states = slice(len(self) - 1, None) if target.suffix == ".png" else slice(None)
        times, positions = self.times[states], self.positions[states].astype(float)
        if positions.size > 3 * most_places:
            raise ValueError(f"{positions.size // 3} places are too many for a page: record at most {most_places}")
        if not np.isfinite(positions).all():
            raise ValueError("positions are infinite or not a number: there is no picture of them")
        step = float(times[1] - times[0]) if len(times) > 1 and times[1] > times[0] else 1 / 30
        scene = {"format": "dvdx-scene/1", "name": target.stem, "step": step, "duration": step * (len(times) - 1)}
        with tempfile.TemporaryDirectory() as folder:
            if any(self._joined()):
                pathlib.Path(folder, "joined.obj").write_text(self._mesh(positions[0]), encoding="ascii")
                scene["network"] = {"type": "mesh", "file": "joined.obj", "mass": 1, "weld": None, "unreferenced": "keep"}
            else:
                scene["particles"] = {"count": positions.shape[1], "position": {"values": positions[0].tolist()}}
            if len(times) > 1:
                ways = (positions - positions[0]).swapaxes(0, 1).tolist()  # of each particle, from where it starts
                keys = [[{"time": k * step, "translation": at} for k, at in enumerate(way)] for way in ways]
                scene["motions"] = {str(i): {"keys": each} for i, each in enumerate(keys)}
                scene["kinematic"] = [{"particles": [i], "motion": str(i)} for i in range(len(keys))]
            else:
                scene["fixed"] = list(range(positions.shape[1]))
            bodies = [(kind, given) for kind, given in self._items if kind in _BODIES]
            scene["contacts"] = [_body(kind, given, folder, i) for i, (kind, given) in enumerate(bodies)]
            file = pathlib.Path(folder, "recorded.json")
            file.write_text(json.dumps(scene), encoding="utf-8")
            drawn = pathlib.Path(folder, f"drawn{target.suffix}")
            line = [program, "run", str(file), "--precision", "float64", "--out", str(drawn), "--every", "1"]
            told = subprocess.run(line if target.suffix != ".png" else line[:-2], capture_output=True, text=True, check=False)
            if told.returncode != 0 or not drawn.exists():
                raise RuntimeError(f"{target}: {told.stderr.strip() or told.stdout.strip()}")
            shutil.copyfile(drawn, target)


most_places = 2_000_000  # of particles, in all states of a page
_BODIES = ("plane", "sphere", "capsule", "box", "convex", "mesh")
_SHAPES = {"normal", "offset", "center", "radius", "side", "ends", "half_extents", "rotation"}


def _body(kind: str, given: Dict[str, Any], folder: str, number: int) -> Dict[str, Any]:
    """A contact of a scene file: its shape alone."""
    body: Dict[str, Any] = {"type": kind}
    for key in _SHAPES & given.keys():
        body[key] = given[key] if isinstance(given[key], str) else np.asarray(given[key]).tolist()
    if kind == "convex":
        rows = np.asarray(given["planes"], float).tolist()
        body["planes"] = [{"normal": row[:3], "offset": row[3]} for row in rows]
    elif kind == "mesh":
        body["file"] = f"body{number}.obj"
        points = "".join("v %.17g %.17g %.17g\n" % tuple(point) for point in np.asarray(given["vertices"], float).tolist())
        corners = "".join("f %d %d %d\n" % tuple(three) for three in (np.asarray(given["triangles"]) + 1).tolist())
        pathlib.Path(folder, body["file"]).write_text(points + corners, encoding="ascii")
    return body
