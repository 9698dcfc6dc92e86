"""Meshes of .obj files as the command reads them: vertices, faces, lines; welded, with sides, diagonals and bends."""

from __future__ import annotations

import math
import os
import pathlib
import re
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple, Union

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Pair = Tuple[int, int]


class Mesh(NamedTuple):
    """A file's numbers, counted from 0."""

    vertices: Array  # (n, 3), m
    faces: List[List[int]]
    lines: List[Pair]


def read_mesh(path: Union[str, "os.PathLike[str]"]) -> Mesh:
    """The v, f and l of an .obj file."""
    text = re.sub(r"\r\n?", "\n", pathlib.Path(path).read_text(encoding="utf-8-sig"))
    continued = 1
    while continued:  # a line goes on in the next
        text, continued = re.subn(r"^([^#\n]*)\\\n", r"\1 ", text, flags=re.MULTILINE)
    vertices: List[List[float]] = []
    faces: List[List[int]] = []
    lines: List[Pair] = []
    for number, line in enumerate(text.split("\n"), 1):
        key, *values = line.split("#")[0].split() or [""]
        key = key.lower()
        try:
            if key == "v":
                vertices.append([_finite(value) for value in values[:3]])
                if len(values) < 3:
                    raise ValueError(f"{len(values)} numbers: a vertex has 3")
            elif key in ("f", "fo", "l"):
                named = [_index(value.split("/")[0], len(vertices)) for value in values]
                least, what = (2, "a line") if key == "l" else (3, "a face")
                if len(named) < least:
                    raise ValueError(f"{len(named)} vertices: {what} has at least {least}")
                if key == "l":
                    lines += [(a, b) for a, b in zip(named, named[1:])]
                elif len(set(named)) < len(named):
                    raise ValueError("a vertex twice in a face")
                else:
                    faces.append(named)
        except ValueError as fault:
            raise ValueError(f"{path}: line {number}: {fault}") from None
    largest = max((vertex for face in [*faces, *lines] for vertex in face), default=-1)
    if not vertices or largest >= len(vertices):
        raise ValueError(f"{path}: vertex {largest + 1} is named: there are {len(vertices)}")
    return Mesh(np.array(vertices), faces, lines)


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text}: must be a finite number")
    return value


def _index(text: str, read: int) -> int:
    value = int(text)
    if value == 0 or -value > read:
        raise ValueError(f"vertex {text}: must be from 1 on, or count back from -1")
    return value - 1 if value > 0 else read + value


def length(vector: Sequence[float]) -> float:
    """m: rounded as the command rounds it."""
    x, y, z = (abs(float(each)) for each in vector)
    largest = max(x, y, z)
    if largest == 0:
        return 0.0
    x, y, z = x / largest, y / largest, z / largest
    return largest * math.sqrt(x * x + y * y + z * z)


def welded(mesh: Mesh, weld: Optional[float], keep: bool) -> Tuple[Mesh, Array]:
    """The mesh of particles, and the particle of each vertex: -1 where it is left out."""
    count = len(mesh.vertices)
    first = _firsts(mesh.vertices, weld)
    used = {first[vertex] for face in [*mesh.faces, *mesh.lines] for vertex in face}
    keep = keep or not (mesh.faces or mesh.lines)
    particles = np.full(count, -1, np.int64)
    numbers: List[int] = []
    for vertex in range(count):
        if first[vertex] not in used and not keep:
            continue
        if first[vertex] != vertex:
            particles[vertex] = particles[first[vertex]]
        else:
            particles[vertex] = len(numbers)
            numbers.append(vertex)
    if len(numbers) == count:
        return mesh, particles
    return _reduced(mesh, particles, numbers), particles


def _firsts(places: Array, weld: Optional[float]) -> List[int]:
    """The first of those that stand together, for each vertex."""
    first = list(range(len(places)))
    if weld is None:
        return first

    def of(vertex: int) -> int:
        while first[vertex] != vertex:
            first[vertex] = first[first[vertex]]
            vertex = first[vertex]
        return vertex

    def join(a: int, b: int) -> None:
        low, high = sorted((of(a), of(b)))
        first[high] = low

    if weld == 0:
        seen: Dict[Tuple[float, ...], int] = {}
        for vertex, place in enumerate(places.tolist()):
            join(seen.setdefault(tuple(place), vertex), vertex)
    else:
        reach = weld + 4 * np.finfo(float).eps * float(np.abs(places).max())
        cells: Dict[Tuple[int, ...], List[int]] = {}
        for vertex, cell in enumerate(np.floor(places / reach).astype(np.int64).tolist()):
            for near in np.ndindex(3, 3, 3):
                for other in cells.get(tuple(c + d - 1 for c, d in zip(cell, near)), ()):
                    if length(places[vertex] - places[other]) <= reach:
                        join(other, vertex)
            cells.setdefault(tuple(cell), []).append(vertex)
    return [of(vertex) for vertex in range(len(places))]


def _reduced(mesh: Mesh, particles: Array, numbers: List[int]) -> Mesh:
    """Faces that fall together are one, and those that become a line are lines."""
    faces: List[List[int]] = []
    lines: List[Pair] = []
    seen: Set[Tuple[int, ...]] = set()

    def add(face: List[int]) -> None:
        for k in range(1, len(face)):
            if face[k] in face[:k]:  # cut in two where it comes by a particle twice
                before = face.index(face[k])
                add(face[before:k])
                add(face[:before] + face[k:])
                return
        if len(face) == 2:
            lines.append((face[0], face[1]))
        elif len(face) > 2 and tuple(sorted(face)) not in seen:
            seen.add(tuple(sorted(face)))
            faces.append(face)

    lines += [(a, b) for a, b in ((int(particles[a]), int(particles[b])) for a, b in mesh.lines) if a != b]
    for face in mesh.faces:
        add([int(particles[vertex]) for vertex in face])
    return Mesh(mesh.vertices[numbers], faces, lines)


def triangles(mesh: Mesh) -> Array:
    """Faces cut from their first corner, (n, 3)."""
    cut = [[face[0], face[k - 1], face[k]] for face in mesh.faces for k in range(2, len(face))]
    return np.array(cut, np.uint32).reshape(-1, 3)


def _unique(pairs: Sequence[Pair]) -> List[Pair]:
    return sorted({(min(a, b), max(a, b)) for a, b in pairs})


def edges(mesh: Mesh) -> List[Pair]:
    sides = [(face[k - 1], face[k]) for face in mesh.faces for k in range(len(face))]
    return _unique([*sides, *mesh.lines])


def diagonals(mesh: Mesh) -> List[Pair]:
    found: List[Pair] = []
    for face in mesh.faces:
        found += [(face[0], face[k]) for k in range(2, len(face) - 1)]
        if len(face) == 4:
            found.append((face[1], face[3]))
    return _unique(found)


def bends(mesh: Mesh) -> List[Pair]:
    """Across each side of two faces, and across the corners of faces of more than four."""
    at: Dict[Pair, List[Pair]] = {}
    found: List[Pair] = []
    for face in mesh.faces:
        n = len(face)
        for k in range(n):
            a, b = face[k], face[(k + 1) % n]
            before, after = face[k - 1], face[(k + 2) % n]
            at.setdefault((min(a, b), max(a, b)), []).append((before, after) if a < b else (after, before))
        if n > 4:
            found += [(face[k - 1], face[k + 1]) for k in range(2, n - 1)]
    for next_to in at.values():
        for one, other in zip(next_to, next_to[1:]):
            found += [(a, b) for a, b in zip(one, other) if a != b]
    return _unique(found)
