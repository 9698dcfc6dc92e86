"""Steps particles that lie in NumPy arrays, by dvdx's C API; nothing is copied.

    scene = dvdx.Scene()
    scene.constant(acceleration=(0, -9.81, 0))
    scene.plane(normal=(0, 1, 0), restitution=0.4)
    state = dvdx.State(positions, velocities)  # two (n, 3) arrays, six columns or one structured array
    plan = dvdx.compile(scene, state, step=1 / 60)
    plan.step(state, 60)                       # positions and velocities have moved

SI units; names, units and ranges are those of dvdx/scene.hpp. Needs cffi and NumPy (Debian: python3-cffi, python3-numpy), and
the library with its header: those under DVDX_PREFIX, else those in this package (a wheel brings them), else those that it was
installed with, else the system's.
"""

from __future__ import annotations

import inspect
import itertools
import json
import operator
import os
import pathlib
import re
import subprocess
import tempfile
import warnings
from typing import Any, Dict, Iterator, List, Literal, NamedTuple, Optional, Sequence, Set, Tuple, Type, Union

import cffi
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._recording import Recording, command
from ._scene_file import FORCES, read_scene

__all__ = [
    "COLUMNS", "ContactReport", "DvdxError", "Energy", "Instance", "LifecyclePlan", "LivePlan", "LiveState", "LiveWorkspace", "Plan",
    "Recording", "Scene", "State", "Threads", "Workspace", "bounds", "build_info", "compile", "compile_live", "grid_normals",
    "report", "step_all", "triangle_normals",
]  # fmt: skip

COLUMNS = ("x", "y", "z", "vx", "vy", "vz")

# A vector is three numbers, m or m/s; an array of them has the shape (n, 3).
Array = NDArray[Any]
Method = Literal["combined", "exact", "average_acceleration", "pulse", "symplectic_euler"]
Side = Literal["outside", "inside"]
Response = Literal["resume", "seed"]
Sweep = Literal["curve", "line"]


def _load() -> Tuple[Any, Any, str, int, pathlib.Path]:
    """The header and the library, in cffi's hands, the number of the binary interface that they speak, and where they lie."""
    own = pathlib.Path(__file__).resolve().parents
    prefixes = [pathlib.Path(p) for p in (os.environ.get("DVDX_PREFIX"), own[0], *own[4:5], "/usr/local", "/usr") if p]
    for prefix in prefixes:
        include = prefix / "include/dvdx"
        libraries = [*prefix.glob("lib*/libdvdx.so"), *prefix.glob("lib/*/libdvdx.so")]
        if (include / "dvdx.h").exists() and libraries:
            header = _with_parts(include, "dvdx.h", set())
            version = (include / "version.h").read_text(encoding="utf-8")
            abi_version = re.search(r"DVDX_ABI_VERSION (\d+)", version)
            if abi_version is None:
                raise ImportError(f"{include / 'version.h'} has no DVDX_ABI_VERSION")
            ffi = cffi.FFI()
            ffi.cdef(_declarations(header))
            return ffi, ffi.dlopen(str(libraries[0])), header, int(abi_version[1]), libraries[0].parent
    raise ImportError(f"no include/dvdx/dvdx.h and libdvdx.so under {', '.join(map(str, prefixes))}: set DVDX_PREFIX")


def _with_parts(include: pathlib.Path, name: str, seen: Set[str]) -> str:
    """A header with the parts that it includes, each once."""
    if name in seen:
        return ""
    seen.add(name)
    text = (include / name).read_text(encoding="utf-8")
    return re.sub(r'^#include "dvdx/(c/\w+\.h)"', lambda part: _with_parts(include, part[1], seen), text, flags=re.MULTILINE)


def _declarations(header: str) -> str:
    """The part of a C header that cffi can read: no comments, no preprocessor, nothing for C++."""
    text = re.sub(r"//[^\n]*", "", header)
    text = re.sub(r"^#ifdef __cplusplus.*?^#endif", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^#[^\n]*", "", text, flags=re.MULTILINE)
    return text.replace("DVDX_EXPORT", "")


_ffi, _lib, _header, _abi_version, _folder = _load()
__version__: str = _ffi.string(_lib.dvdx_version()).decode()


def _load_team() -> Any:
    """OpenMP's threads, which are in a library of their own; None where it was not built."""
    library = _folder / "libdvdx_openmp.so"
    if not library.exists():
        return None
    _ffi.cdef("""
        typedef struct dvdx_team dvdx_team;
        dvdx_team* dvdx_team_create(int threads);
        void dvdx_team_destroy(dvdx_team* team);
        dvdx_parallel dvdx_team_parallel(const dvdx_team* team);
        int dvdx_team_threads(const dvdx_team* team);
    """)
    return _ffi.dlopen(str(library))


_team_lib = _load_team()


class DvdxError(Exception):
    """An error in a scene, an option or a state: the field ("forces[2].stiffness"), its value, and what is valid.

    Those that are raised are also Python's own: a ValueError where a value is out of its range or a count is wrong, a TypeError
    where a state's numbers are of another type than a plan's, MemoryError, else a RuntimeError.
    """

    def __init__(self, message: str, field: str = "", value: str = "", valid: str = "") -> None:
        super().__init__(message)
        self.field, self.value, self.valid = field, value, valid


class _ValueError(DvdxError, ValueError):
    pass


class _TypeError(DvdxError, TypeError):
    pass


class _MemoryError(DvdxError, MemoryError):
    pass


class _RuntimeError(DvdxError, RuntimeError):
    pass


for _error in (_ValueError, _TypeError, _MemoryError, _RuntimeError):
    _error.__name__ = _error.__qualname__ = "DvdxError"
_ERRORS: Dict[int, Type[DvdxError]] = {
    _lib.DVDX_PRECISION_DIFFERS: _TypeError,
    _lib.DVDX_OUT_OF_MEMORY: _MemoryError,
    **dict.fromkeys((_lib.DVDX_IN_USE, _lib.DVDX_ABI_DIFFERS, _lib.DVDX_FAILED), _RuntimeError),
}


def _call(function: Any, *arguments: Any) -> None:
    error = _ffi.new("dvdx_error*")
    try:
        status = function(*arguments, error)
    except OverflowError as fault:  # cffi's, of a number that C's type does not hold
        raise ValueError(f"a number or a count is out of its range: {fault}") from None
    if status != _lib.DVDX_DONE:
        words = (_ffi.string(getattr(error, name)).decode() for name in ("message", "field", "value", "valid"))
        raise _ERRORS.get(status, _ValueError)(*words)


def _whole(value: Any, name: str, least: int = 0) -> int:
    number = operator.index(value)
    if number < least:
        raise ValueError(f"{name} is {number}: must be a whole number >= {least}")
    return number


def _text(function: Any, *arguments: Any) -> str:
    size = function(*arguments, _ffi.NULL, 0) + 1
    text = _ffi.new("char[]", size)
    function(*arguments, text, size)
    return _ffi.string(text).decode()


# ---- Python's values to C's structs, by the types that the header gives to their fields ------------------------------------


def _words(enum: Any) -> Dict[str, int]:
    """{"curve": 0, "line": 1} of dvdx_sweep {DVDX_SWEEP_CURVE, DVDX_SWEEP_LINE}"""
    prefix = f"{enum.cname.removeprefix('enum ')}_".upper()
    return {name.removeprefix(prefix).removeprefix("DVDX_").lower(): value for value, name in sorted(enum.elements.items())}


def _choice(enum: Any, word: str) -> int:
    words = _words(enum)
    if word not in words:
        raise ValueError(f"{word!r}: must be one of {', '.join(words)}")
    return words[word]


def _rows(value: Any, kind: str, width: Optional[int], keep: List[Any]) -> Tuple[Any, int]:
    """A C array of rows of so many numbers, and how many rows."""
    rows = np.asarray(value)
    type_ = {"double": np.float64, "uint16_t": np.uint16, "uint32_t": np.uint32, "size_t": np.uintp}[kind]
    if kind != "double" and (rows.dtype.kind not in "iu" or (rows < 0).any() or (rows > np.iinfo(type_).max).any()):
        raise ValueError(f"numbers of particles, or groups, must be whole, from 0 to {np.iinfo(type_).max}")
    if width and (rows.ndim != 2 or rows.shape[1] != width):
        raise ValueError(f"shape {rows.shape}: must be (n, {width})")
    if not width and rows.ndim != 1:
        raise ValueError(f"shape {rows.shape}: must be (n,)")
    rows = np.ascontiguousarray(rows, type_)
    keep.append(_ffi.from_buffer(f"{kind}[]", rows))
    return keep[-1], len(rows)


def _vector(value: Any) -> List[float]:
    if np.shape(value) != (3,):
        raise ValueError(f"shape {np.shape(value)}: must be three numbers")
    return [float(number) for number in value]


def _array(value: Any, field: Any) -> List[Any]:
    """The numbers of a fixed array: a vector, a few numbers, or a few vectors."""
    if field.length == 3:
        return _vector(value)
    if np.ndim(value) == 0 and field.item.kind == "primitive":
        value = [value] * field.length  # alike: a capsule's radius
    if len(value) != field.length:
        raise ValueError(f"{len(value)} values: must be {field.length}")
    return [_vector(each) if field.item.kind == "array" else float(each) for each in value]


def _fill_scalars(struct: Any, value: Any, keep: List[Any]) -> None:
    if np.ndim(value) == 0:
        struct.all = value
    else:
        struct.each, struct.count = _rows(value, "double", None, keep)


def _fill_per_axis(struct: Any, value: Any, keep: List[Any]) -> None:
    if isinstance(value, (tuple, list)):
        struct.axes, count = _rows(value, "double", None, keep)
        if count != 3:
            raise ValueError(f"{count} numbers: must be one, three (one an axis) or an array with one a particle")
    else:
        _fill_scalars(struct, value, keep)


def _fill_anchor(struct: Any, value: Any, keep: List[Any]) -> None:
    if isinstance(value, str):
        if value != "start":
            raise ValueError(f"{value!r}: must be a point, a point for each particle, or 'start'")
        setattr(struct, "from", _lib.DVDX_ANCHOR_AT_START)
    elif np.ndim(value) == 1:
        struct.at = _vector(value)
    else:
        setattr(struct, "from", _lib.DVDX_ANCHOR_EACH)
        struct.each, struct.count = _rows(value, "double", 3, keep)


_LENGTHS = {"spread_box": 3, "inside": 6}
# Numbers a row, where they are not those of a point or a pair.
_WIDTHS = {"keys": 7, "planes": 4, "particles": None, "vertices": 3, "triangles": 3, "gusts": 5, "of": None, "meet": 2}
# Counts of the rows of lists that have not their struct's own count.
_COUNTS = {"triangles": "triangle_count", "meet": "pair_count"}
_FILL = {"dvdx_scalars": _fill_scalars, "dvdx_per_axis": _fill_per_axis, "dvdx_anchor": _fill_anchor}


def _fill_field(struct: Any, name: str, field: Any, value: Any, keep: List[Any]) -> None:
    if field.kind == "enum":
        setattr(struct, name, _choice(field, value))
    elif field.cname in _FILL:
        _FILL[field.cname](getattr(struct, name), value, keep)
    elif field.kind == "array":
        setattr(struct, name, _array(value, field))
    elif field.kind != "pointer":
        setattr(struct, name, value)
    elif field.item.cname == "dvdx_scalars":
        if value is not None and not isinstance(value, str):  # else the distances at the start
            keep.append(_ffi.new("dvdx_scalars*"))
            setattr(struct, name, keep[-1])
            _fill_scalars(getattr(struct, name), value, keep)
        elif value not in (None, "start"):
            raise ValueError(f"{value!r}: must be a number, one a pair, or 'start'")
    elif name in _LENGTHS:
        rows, count = _rows(np.ravel(value), "double", None, keep)
        if count != _LENGTHS[name]:
            raise ValueError(f"{count} numbers: must be {_LENGTHS[name]}")
        setattr(struct, name, rows)
    else:
        width = _WIDTHS.get(name, 2 if field.item.cname == "uint32_t" else 3)
        rows, count = _rows(value, field.item.cname, width, keep)
        own = _COUNTS.get(name, "terms")
        own = own if hasattr(struct, own) else "count"
        if getattr(struct, own) not in (0, count):
            raise ValueError(f"{count} rows: must be {getattr(struct, own)}, as there are of the others")
        setattr(struct, name, rows)
        setattr(struct, own, count)


def _fields(kind: str) -> Dict[str, Tuple[Optional[str], Any]]:
    """Every keyword of a struct, with the types on the way to it: a surface's are those of the contact that has it."""
    fields: Dict[str, Tuple[Optional[str], Any]] = {}
    for name, field in _ffi.typeof(kind).fields:
        if name == "surface":
            fields |= {inner: ("surface", type_) for inner, (_, type_) in _fields(field.type.cname).items()}
        elif name not in ("count", "terms", *_COUNTS.values()):
            fields[name] = (None, field.type)
    return fields


def _struct(kind: str, keywords: Dict[str, Any], keep: List[Any]) -> Any:
    struct, fields = _ffi.new(f"{kind}*"), _fields(kind)
    for name, value in keywords.items():
        if name not in fields:
            raise TypeError(f"{kind.removeprefix('dvdx_')} has no {name}: there are {', '.join(fields)}")
        inside, field = fields[name]
        try:
            _fill_field(getattr(struct, inside) if inside else struct, name, field, value, keep)
        except (ValueError, OverflowError) as fault:
            raise ValueError(f"{name}: {fault}") from None
        except TypeError as fault:
            raise TypeError(f"{name}: {fault}") from None
    return struct


# ---- Scenes ----------------------------------------------------------------------------------------------------------------


class Scene:
    """The contents of the world: a method for each force, contact, network and constraint. Each adds one and gives the scene.

        scene = dvdx.Scene(mass=0.01, fixed=[0, 47])
        scene.constant(acceleration=(0, -9.81, 0)).sphere(center=(0, 1, 0), radius=0.2, friction=0.3)

    mass: kg, one for all particles or one for each. fixed: particles that never move. origin, a point or one for each particle:
    where a state's positions are measured from. method: of every force that names none.
    Vectors are three numbers; choices are words. Forces, contacts, networks, constraints, motions and skins are counted from 0,
    each kind by itself, in the order in which they are added. Scene.load() reads a scene file.
    """

    step: Optional[float] = None
    """s, of a scene that was loaded: what compile() takes where no step is given."""
    duration: Optional[float] = None
    """s, of a scene that was loaded."""
    tears_at: Dict[int, float] = {}
    """How far springs of these networks stretch before they tear, in a scene that was loaded: see Plan.run()."""
    turnover: Optional[Dict[str, Any]] = None
    """Emitters and removal of a scene that was loaded: what compile_live() takes where nothing else is given."""

    def __init__(
        self, method: Optional[Method] = None, mass: Optional[ArrayLike] = None, fixed: ArrayLike = (),
        origin: Optional[ArrayLike] = None,
    ) -> None:  # fmt: skip
        keep: List[Any] = []
        handle = _ffi.new("dvdx_scene**")
        _call(_lib.dvdx_scene_create, _abi_version, handle)
        self._take(handle[0], {"method": method, "mass": mass, "fixed": fixed, "origin": origin}, [])
        if method is not None:
            _call(_lib.dvdx_scene_set_method, self._handle, _choice(_ffi.typeof("dvdx_method"), method))
        if mass is not None:
            scalars = _ffi.new("dvdx_scalars*")
            _fill_scalars(scalars, mass, keep)
            _call(_lib.dvdx_scene_set_mass, self._handle, scalars)
        if np.size(fixed):
            _call(_lib.dvdx_scene_set_fixed, self._handle, *_rows(np.unique(np.asarray(fixed)), "size_t", None, keep))
        if origin is not None:
            _call(_lib.dvdx_scene_set_origin, self._handle, *_rows(np.atleast_2d(origin), "double", 3, keep))

    def _take(self, handle: Any, about: Dict[str, Any], items: List[Tuple[str, Dict[str, Any]]]) -> None:
        self._handle = _ffi.gc(handle, _lib.dvdx_scene_destroy)
        self._about, self._items = about, items  # as they were given: for people, and for drawing
        self._start: Optional[Tuple[Array, Array]] = None

    def _add(self, kind: str, given: Dict[str, Any]) -> Scene:
        keywords = {name: value for name, value in given.items() if name != "self" and value is not None}
        keep: List[Any] = []
        _call(getattr(_lib, _ADDERS[kind]), self._handle, _struct(kind, keywords, keep))
        self._items.append((kind.removeprefix("dvdx_"), keywords))
        return self

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> Scene:
        """The scene of a file (dvdx-scene/1), with its step and duration; state() is how it starts.

        Not read, and refused by name: springs that are torn from the start, and grids of one row.
        Nothing is done that `dvdx run` does of its own: it measures float32 states from an origin nearby where they start far out,
        and tears springs (tears_at), as Plan.run() does.
        """

        return read_scene(cls, path)

    def state(self, dtype: Any = np.float64) -> State:
        """A state of its own for a scene that was loaded, as the file starts; dtype: float32 or float64."""
        if self._start is None:
            raise ValueError("the scene was not loaded: State(positions, velocities) says where its particles are")
        return State(*(np.array(each, dtype) for each in self._start))

    def live_state(self, dtype: Any = np.float64) -> LiveState:
        """Likewise where particles come and go: the file's own live first, and die of no age."""
        if self._start is None or self.turnover is None:
            raise ValueError("the scene was not loaded from a file with emitters or a capacity")
        capacity, count = self.turnover["capacity"], len(self._start[0])
        arrays = [np.zeros((capacity, 3), dtype) for _ in range(2)]
        for array, start in zip(arrays, self._start):
            array[:count] = start
        return LiveState(*arrays, count=count, age=np.zeros(capacity, dtype), lifetime=np.full(capacity, np.inf, dtype))

    @property
    def last(self) -> int:
        """The number of what was added last, among those of its kind: what set_force(), set_contact(), set_pose() ... take."""
        if not self._items:
            raise IndexError("the scene is empty")
        kind = self._items[-1][0]
        alike = next((kinds for kinds in _LISTS if kind in kinds), (kind,))
        return sum(other in alike for other, _ in self._items) - 1

    def __repr__(self) -> str:
        given = {name: value for name, value in self._about.items() if value is not None and np.size(value)}
        about = ", ".join(f"{name}={_shown(value)}" for name, value in given.items())
        return f"dvdx.Scene({about}){''.join(f'.{name}({_keywords(name, given)})' for name, given in self._items)}"

    # ---- forces

    def constant(self, *, acceleration: ArrayLike, method: Optional[Method] = None) -> Scene:
        """a = acceleration, m/s^2."""
        return self._add("dvdx_constant", locals())

    def polynomial(self, *, acceleration: ArrayLike, method: Optional[Method] = None) -> Scene:
        """a = sum of acceleration[k] t^k, t the scene's time; 1 to 8 rows, m/s^2, m/s^3, ..."""
        return self._add("dvdx_polynomial", locals())

    def sinusoid(
        self, *, acceleration: ArrayLike, angular_frequency: float, phase: float = 0, method: Optional[Method] = None,
    ) -> Scene:  # fmt: skip
        """a = acceleration sin(angular_frequency t + phase); m/s^2, rad/s, rad."""
        return self._add("dvdx_sinusoid", locals())

    def spring(
        self, *, stiffness: ArrayLike, damping: float = 0, anchor: Union[ArrayLike, Literal["start"]] = (0, 0, 0),
        method: Optional[Method] = None,
    ) -> Scene:  # fmt: skip
        """m a = -stiffness (x - anchor) - damping v; N/m >= 0, kg/s >= 0, m.

        stiffness: a number, an array with one for each particle, or a tuple of three, one for each axis. anchor: a point, an
        array of them, or "start": where each particle is when the plan is compiled.
        """
        return self._add("dvdx_spring", locals())

    def radial_spring(
        self, *, stiffness: ArrayLike, rest_length: ArrayLike = 0, damping: float = 0, anchor: Union[ArrayLike,
        Literal["start"]] = (0, 0, 0), method: Optional[Method] = None,
    ) -> Scene:  # fmt: skip
        """m a = -(stiffness (r - rest_length) + damping r') n along the line from the anchor; N/m, m, kg/s, all >= 0."""
        return self._add("dvdx_radial_spring", locals())

    def drag(
        self, *, coefficient: ArrayLike, wind: ArrayLike = (0, 0, 0), expansion: Literal["exact", "first_order"] =
        "exact", method: Optional[Method] = None,
    ) -> Scene:  # fmt: skip
        """m a = -coefficient (v - wind); kg/s >= 0, m/s.

        coefficient: a number, an array with one for each particle, or a tuple of three, one for each axis.
        """
        return self._add("dvdx_drag", locals())

    # ---- contacts: what particles meet
    #
    # restitution: 0..1. friction: Coulomb's, >= 0. viscosity, normal_viscosity >= 0: an impact multiplies the tangential and
    # the normal velocity by exp(-viscosity). thickness: m that particles are kept off the surface. push_out: m/s at which what
    # is inside when a step begins leaves it; None: it is put onto the surface within that step.

    def plane(
        self, *, normal: ArrayLike, offset: float = 0, restitution: float = 0, friction: float = 0,
        viscosity: float = 0, normal_viscosity: float = 0, response: Response = "resume", sweep: Sweep = "curve",
        thickness: float = 0, push_out: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles may be where normal . x >= offset, m; the normal, of any length > 0, is taken to length 1."""
        return self._add("dvdx_plane", locals())

    def sphere(
        self, *, center: ArrayLike = (0, 0, 0), radius: float, side: Side = "outside", restitution: float = 0,
        friction: float = 0,
        viscosity: float = 0, normal_viscosity: float = 0, response: Response = "resume", sweep: Sweep = "curve",
        thickness: float = 0, push_out: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles may be outside, or inside, of a sphere; m."""
        return self._add("dvdx_sphere", locals())

    def capsule(
        self, *, ends: ArrayLike, radius: ArrayLike, restitution: float = 0, friction: float = 0,
        viscosity: float = 0, normal_viscosity: float = 0, response: Response = "resume", sweep: Sweep = "curve",
        thickness: float = 0, push_out: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles may be outside the convex hull of two spheres: ends are two points, m; radius a number, or one for each."""
        return self._add("dvdx_capsule", locals())

    def box(
        self, *, center: ArrayLike = (0, 0, 0), half_extents: ArrayLike, rotation: ArrayLike = (0, 0, 0), side: Side =
        "outside", restitution: float = 0, friction: float = 0,
        viscosity: float = 0, normal_viscosity: float = 0, response: Response = "resume", sweep: Sweep = "curve",
        thickness: float = 0, push_out: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles may be outside, or inside, of a box; m; rotation: axis times angle, rad."""
        return self._add("dvdx_box", locals())

    def convex(
        self, *, planes: ArrayLike, restitution: float = 0, friction: float = 0,
        viscosity: float = 0, normal_viscosity: float = 0, response: Response = "resume", sweep: Sweep = "curve",
        thickness: float = 0, push_out: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles may be outside the body where normal . x <= offset for all planes: 4 to 64 rows of normal and offset."""
        return self._add("dvdx_convex", locals())

    def mesh(
        self, *, vertices: ArrayLike, triangles: ArrayLike, cell: float = 0, restitution: float = 0, friction: float = 0,
        viscosity: float = 0, normal_viscosity: float = 0, response: Response = "resume", sweep: Sweep = "curve",
        thickness: float = 0, push_out: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles may be outside a closed surface of triangles, rows of three vertices, counter-clockwise seen from outside.

        cell: m, of the grid that it is sampled to; 0: the longest side / 64.
        """
        return self._add("dvdx_mesh", locals())

    # ---- networks: springs between particles

    def coupling(
        self, *, scheme: Literal["leapfrog", "fourth_order", "sequential", "accumulate", "automatic"] = "leapfrog",
        substeps: int = 0, theta: float = 0, sweeps: Literal["symmetric", "forward"] = "symmetric",
        lines: Literal["rows", "whole", "none"] = "rows", method: Optional[Method] = None,
        axis: Literal["midpoint", "start"] = "midpoint", iterations: int = 0, longest_substep: float = 0,
        most_substeps: int = 0,
    ) -> Scene:  # fmt: skip
        """How networks and constraints are stepped: Coupling in network.hpp. substeps a step; 0: as many as are needed."""
        return self._add("dvdx_coupling", locals())

    def grid(
        self, *, rows: int, columns: int, edge_u: ArrayLike, edge_v: ArrayLike, first: int = 0, structural: float = 0,
        shear: float = 0, bend: float = 0, damping: float = 0,
    ) -> Scene:  # fmt: skip
        """A sheet: the particle at (row, column) is first + row * columns + column.

        edge_u, edge_v: m, what a row's columns and the rows span when it is flat, which gives rest lengths. structural between
        neighbours, shear along diagonals, bend between every second: N/m >= 0. damping along each spring: kg/s >= 0.
        """
        return self._add("dvdx_grid", locals())

    def springs(
        self, *, pairs: ArrayLike, stiffness: ArrayLike, rest_length: Union[ArrayLike, Literal["start"], None] = None,
        damping: float = 0,
    ) -> Scene:  # fmt: skip
        """Springs between particles: rows of two. N/m, m, kg/s, all >= 0; numbers are one for all or one for each pair.

        rest_length: "start" and None take each pair's distance when the plan is compiled.
        """
        return self._add("dvdx_springs", locals())

    def aerodynamics(
        self, *, network: int = 0, density: float = 1.2, drag: float = 1, lift: float = 0.5, triangles:
        Optional[ArrayLike] = None,
    ) -> Scene:  # fmt: skip
        """A network meets the air by triangles: rows of three particles, of springs alone; a grid has its own. kg/m^3 >= 0."""
        return self._add("dvdx_aerodynamics", locals())

    def bending(self, *, network: int = 0, modulus: float, triangles: ArrayLike, flat: ArrayLike) -> Scene:
        """Springs also bend by the angles across the edges of triangles; N m >= 0. flat: m, a point for each particle."""
        return self._add("dvdx_bending", locals())

    def wind(self, *, mean: ArrayLike = (0, 0, 0), gusts: Optional[ArrayLike] = None) -> Scene:
        """The air's velocity, m/s. gusts: rows of amplitude, angular frequency (rad/s) and phase (rad), five numbers each."""
        return self._add("dvdx_wind", locals())

    # ---- constraints

    def faces(self, choice: Literal["automatic", "never"]) -> Scene:
        """Whether the triangles of cloth meet bodies that are narrow ("automatic", as where nothing is said), or "never"."""
        _call(_lib.dvdx_scene_set_faces, self._handle, _choice(_ffi.typeof("dvdx_faces"), choice))
        self._items.append(("faces", {"choice": choice}))
        return self

    def distance(
        self, *, pairs: ArrayLike, length: Union[ArrayLike, Literal["start"], None] = None, bound: Literal["equal",
        "at_most", "at_least"] = "equal",
    ) -> Scene:  # fmt: skip
        """The distance of pairs, rows of two particles, is held to a length, m > 0: rods, ropes. "start", None: as they are."""
        return self._add("dvdx_distance", locals())

    def on_point(self, *, particle: int, at: ArrayLike) -> Scene:
        """A particle stays at a point, m."""
        return self._add("dvdx_on_point", locals())

    def on_line(self, *, particle: int, through: ArrayLike, direction: ArrayLike) -> Scene:
        """A particle stays on a straight line."""
        return self._add("dvdx_on_line", locals())

    # ---- what moves by itself, or by Plan.set_pose() and its like

    def motion(self, *, keys: ArrayLike = ((0, 0, 0, 0, 0, 0, 0),), center: ArrayLike = (0, 0, 0)) -> Scene:
        """A rigid motion: rows of time, translation and rotation vector, seven numbers each; s, m, rad. Without keys it rests.

        A key carries a point p to center + R (p - center) + translation.
        """
        return self._add("dvdx_motion", locals())

    def jump(self, motion: int, key: int) -> Scene:
        """No way leads to key `key` of motion `motion` from the key before: there it jumps."""
        _call(_lib.dvdx_scene_set_jump, self._handle, motion, key)
        return self

    def contact_motion(self, contact: int, motion: int) -> Scene:
        """Contact `contact` follows motion `motion`."""
        _call(_lib.dvdx_scene_set_contact_motion, self._handle, contact, motion)
        return self

    def skin_motion(self, skin: int, motion: int) -> Scene:
        """Skin `skin` follows motion `motion`."""
        _call(_lib.dvdx_scene_set_skin_motion, self._handle, skin, motion)
        return self

    def kinematic(self, *, particles: ArrayLike, motion: int = 0) -> Scene:
        """Particles that nothing acts on: each is where the motion carries the place at which it stood at compile()."""
        return self._add("dvdx_kinematic", locals())

    def skin(self, *, particles: ArrayLike, points: Optional[ArrayLike] = None, at_most: Optional[ArrayLike] = None) -> Scene:
        """Particles that stay near points that move, by Plan.set_skin(): within at_most, m, a number or one for each.

        points: m, one for each; None: where the particles are when the plan is compiled. at_most None: anywhere.
        """
        return self._add("dvdx_skin", locals())

    def backstop(self, *, skin: int = 0, normals: ArrayLike, offset: ArrayLike = 0, radius: ArrayLike) -> Scene:
        """Behind each point of a skin is a ball that its particle may not enter: its center lies offset + radius behind, m."""
        return self._add("dvdx_backstop", locals())

    def tethers(self, *, network: int = 0, stretch: float = 1) -> Scene:
        """Each particle of a network is at most stretch (>= 1) times so far from what it hangs on as the cloth is long."""
        return self._add("dvdx_tethers", locals())

    # ---- particles that meet

    def meet(
        self, *, radius: Optional[ArrayLike] = None, thickness: Optional[float] = None, restitution: float = 0,
        friction: float = 0, rounds: int = 0, most_neighbours: int = 0,
        near_at_start: Literal["by_kind", "meet", "pass"] = "by_kind", part_of_cells: Optional[float] = None,
    ) -> Scene:  # fmt: skip
        """Particles stay apart: balls by their radius, m, one for all or one for each, or those of networks by a thickness, m.

        part_of_cells: in place of a thickness, each has so much (> 0 and < 1) of the widest cell that it is a corner of.
        restitution: 0..1. friction: Coulomb's, >= 0. rounds a sub-step, most_neighbours of one particle; 0: the default.
        near_at_start: whether pairs that are nearer at the start than they want to be meet; by_kind: balls do, cloth does not.
        """
        return self._add("dvdx_meet", locals())

    def meet_groups(self, *, of: ArrayLike, meet: ArrayLike) -> Scene:
        """Which particles meet, after meet(): a group for each, and rows of two groups that meet each other or themselves."""
        return self._add("dvdx_meet_groups", locals())


_ADDERS = {
    kind: function
    for function, kind in re.findall(r"(dvdx_scene_(?:add_|set_)\w+)\(dvdx_scene\* scene, const (dvdx_\w+)\* (?!mass)", _header)
}


def _scene_method(kind: str) -> Any:
    def add(self: Scene, **keywords: Any) -> Scene:
        return self._add(kind, keywords)

    add.__name__ = kind.removeprefix("dvdx_")
    add.__qualname__ = f"Scene.{add.__name__}"
    add.__doc__ = f"{add.__name__}({', '.join(_fields(kind))}), by keywords; what is left out is 0 or the default."
    return add


for _kind in _ADDERS:  # what the library has and this class does not name
    if not hasattr(Scene, _kind.removeprefix("dvdx_")):
        setattr(Scene, _kind.removeprefix("dvdx_"), _scene_method(_kind))


def _keywords(method: str, given: Dict[str, Any]) -> str:
    """The keywords of a call, without those that are a default."""
    defaults = {name: repr(each.default) for name, each in inspect.signature(getattr(Scene, method)).parameters.items()}
    return ", ".join(f"{name}={_shown(value)}" for name, value in given.items() if _shown(value) != defaults.get(name))


def _shown(value: Any) -> str:
    """A value as one would write it; of an array its shape."""
    if isinstance(value, np.ndarray) or (isinstance(value, (list, tuple)) and np.size(value) > 8):
        return f"<array {np.shape(value)}>"
    return repr(value)


# ---- Particles -------------------------------------------------------------------------------------------------------------


def _numbers(array: Any, what: str) -> Array:
    """A column that dvdx reads must be float32 or float64 in memory, writable and aligned."""
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{what} is {type(array).__name__}: must be a numpy.ndarray, whose memory is stepped")
    if array.dtype not in (np.float32, np.float64):
        raise TypeError(f"{what} is of {array.dtype}: must be float32 or float64 in native byte order")
    if not array.flags.writeable or not array.flags.aligned:
        raise ValueError(f"{what} is read-only or not aligned: its memory cannot be stepped")
    return array


def _columns_of(arrays: Tuple[Array, ...]) -> Dict[str, Array]:
    """The six columns (1-D, views) of whatever a state was made of, named."""
    if len(arrays) == 6:
        return dict(zip(COLUMNS, arrays))
    if len(arrays) == 2:
        for array, what in zip(arrays, ("positions", "velocities")):
            if _numbers(array, what).ndim != 2 or array.shape[1] != 3:
                raise ValueError(f"{what} is of shape {array.shape}: must be (n, 3)")
        return {name: arrays[i // 3][:, i % 3] for i, name in enumerate(COLUMNS)}
    if len(arrays) == 1 and getattr(arrays[0], "dtype", None) is not None and arrays[0].dtype.names:
        (record,) = arrays
        if {"position", "velocity"} <= set(record.dtype.names):
            return _columns_of((record["position"], record["velocity"]))
        if set(COLUMNS) <= set(record.dtype.names):
            return {name: record[name] for name in COLUMNS}
        raise ValueError(f"fields {record.dtype.names}: must hold position and velocity, or {', '.join(COLUMNS)}")
    raise TypeError("a state is six columns, positions and velocities of shape (n, 3), or one structured array")


def _column(in_c: Any, column: Array) -> None:
    """Makes a dvdx_column of a 1-D array."""
    in_c.base = _ffi.cast("void*", column.__array_interface__["data"][0])
    in_c.stride, in_c.run, in_c.capacity = column.strides[0], 1, len(column)
    if column.strides[0] == column.itemsize:
        in_c.run = 0  # side by side


class State:
    """A view of particles: State(x, y, z, vx, vy, vz), State(positions, velocities) or State(structured).

    Six 1-D arrays; two of shape (n, 3); or one structured array with the fields position and velocity (3 numbers each) or x, y,
    z, vx, vy, vz. m and m/s, float32 or float64, all alike; any strides. The arrays are kept, and are what a step writes.
    time: s, or the clock of a state that was stored.
    rests: the residuals, as many arrays of the same kind, zero at first: plans with rounding="compensated" keep in them
      what does not fit.
    """

    def __init__(self, *arrays: Array, time: Union[float, Tuple[float, float]] = 0.0, rests: Sequence[Array] = ()) -> None:
        columns = _columns_of(arrays)
        self._given = arrays
        if len(rests):
            columns |= {f"{name}_rest": column for name, column in _columns_of(tuple(rests)).items()}
        first = next(iter(columns.values()))
        for name, column in columns.items():
            if _numbers(column, name).ndim != 1 or column.shape != first.shape:
                raise ValueError(f"{name} is of shape {column.shape}: must be one number a particle, {first.shape}")
            if column.dtype != first.dtype:
                raise TypeError(f"{name} is of {column.dtype}: must be {first.dtype}, as {COLUMNS[0]} is")
            if column.strides[0] == 0 and len(column) > 1:
                raise ValueError(f"{name}: its elements share memory")
        for one, other in itertools.combinations(columns, 2):
            if np.shares_memory(columns[one], columns[other]):
                raise ValueError(f"{one} and {other} share memory: each needs its own")
        self.arrays = columns
        self._struct = _ffi.new("dvdx_state*", {"count": len(first)})
        self._struct.precision = _lib.DVDX_FLOAT32 if first.dtype == np.float32 else _lib.DVDX_FLOAT64
        self._struct.clock = time if isinstance(time, tuple) else (time, 0)
        for i, column in enumerate(columns.values()):
            _column(getattr(self._struct, ("x", "v", "x_rest", "v_rest")[i // 3])[i % 3], column)

    def __len__(self) -> int:
        return int(self._struct.count)

    def __repr__(self) -> str:
        return f"<dvdx.{type(self).__name__}: {len(self)} particles, {self.arrays['x'].dtype}, time {self.time:g} s>"

    @property
    def positions(self) -> Array:
        """m, of shape (n, 3): the array that was given, or a copy that cannot be written where there are six of them."""
        return self._vectors("position", 0)

    @property
    def velocities(self) -> Array:
        """m/s, likewise."""
        return self._vectors("velocity", 1)

    def _vectors(self, name: str, which: int) -> Array:
        if len(self._given) == 2:
            return self._given[which][: len(self)]
        if len(self._given) == 1 and name in (self._given[0].dtype.names or ()):
            vectors: Array = self._given[0][name][: len(self)]
            return vectors
        stacked = np.stack([self.arrays[column][: len(self)] for column in COLUMNS[3 * which : 3 * which + 3]], axis=1)
        stacked.flags.writeable = False
        return stacked

    @property
    def time(self) -> float:
        """The scene's time, s."""
        return self._struct.clock.seconds

    @property
    def clock(self) -> Tuple[float, float]:
        """The same as a sum of two, which is what a state's next step depends on."""
        return self._struct.clock.seconds, self._struct.clock.carry

    def hash(self) -> str:
        """FNV-1a over all numbers' bits, 64 bits: the state_hash of `dvdx run --json`, as 16 hexadecimal digits."""
        return f"{_lib.dvdx_state_hash(self._struct):016x}"


class LiveState(State):
    """Particles that come and go: arrays as long as the most that may live at once, of which the first len(state) live.

    LiveState(positions, velocities, count=0, age=..., lifetime=..., carried=(ids, ...)): age and lifetime (s) are 1-D arrays of
    the same kind as the columns, or left out; carried are 1-D arrays of any kind whose elements go along with the particles.
    """

    def __init__(
        self, *arrays: Array, count: int = 0, age: Optional[Array] = None, lifetime: Optional[Array] = None,
        carried: Sequence[Array] = (), time: Union[float, Tuple[float, float]] = 0.0,
    ) -> None:  # fmt: skip
        super().__init__(*arrays, time=time)
        capacity, dtype = len(self.arrays["x"]), self.arrays["x"].dtype
        if not 0 <= count <= capacity:
            raise ValueError(f"count {count}: must be from 0 to {capacity}, as long as the arrays are")
        self._live = _ffi.new("dvdx_live*")
        self._live.state = self._struct[0]
        self._struct = _ffi.addressof(self._live, "state")
        self._struct.count = count
        for name, column in (("age", age), ("lifetime", lifetime)):
            if column is None:
                continue
            if _numbers(column, name).shape != (capacity,) or column.dtype != dtype:
                raise ValueError(f"{name} is of shape {column.shape} and {column.dtype}: must be ({capacity},) and {dtype}")
            self.arrays[name] = column
            _column(getattr(self._live, name), column)
        self.carried = tuple(carried)
        self._carried = _ffi.new("dvdx_carried[]", len(self.carried))
        for in_c, column in zip(self._carried, self.carried):
            if not isinstance(column, np.ndarray) or column.shape != (capacity,) or not column.flags.writeable:
                raise ValueError(f"carried: each must be a writable numpy.ndarray of shape ({capacity},)")
            if column.dtype.hasobject:
                raise TypeError("carried: Python's objects cannot be moved as bytes")
            in_c.base = _ffi.cast("void*", column.__array_interface__["data"][0])
            in_c.stride, in_c.bytes = column.strides[0], column.itemsize
        self._live.carried, self._live.carried_count = self._carried, len(self.carried)

    @property
    def born(self) -> int:
        """So far, by the emitters."""
        return int(self._live.born)

    @property
    def removed(self) -> int:
        """So far."""
        return int(self._live.removed)

    @property
    def dropped(self) -> int:
        """Births that found no room."""
        return int(self._live.dropped)


# ---- Plans -----------------------------------------------------------------------------------------------------------------


class Energy(NamedTuple):
    """J: of motion, of springs between particles, and in constant forces, from the world's origin on."""

    kinetic: float
    elastic: float
    weight: float

    @property
    def total(self) -> float:
        return self.kinetic + self.elastic + self.weight


class Threads:
    """Threads for networks and large batches: Threads(4), among them the one that steps; 0: one for each core.

    They wait between steps, and end with this object. The bits of a step do not depend on how many there are.
    """

    def __init__(self, count: int = 0) -> None:
        if _team_lib is None:
            raise RuntimeError(f"no libdvdx_openmp.so in {_folder}: dvdx was built without OpenMP, and steps on one thread")
        self._handle = _ffi.gc(_team_lib.dvdx_team_create(_whole(count, "count")), _team_lib.dvdx_team_destroy)
        if self._handle == _ffi.NULL:
            raise RuntimeError(f"the system has no {count} threads more")
        self._parallel = _ffi.new("dvdx_parallel*", _team_lib.dvdx_team_parallel(self._handle))

    def __repr__(self) -> str:
        return f"<dvdx.Threads: {self.count}>"

    @property
    def count(self) -> int:
        """How many there are, the one that steps among them."""
        return int(_team_lib.dvdx_team_threads(self._handle))


_teams: Dict[int, Threads] = {}  # those that were asked for by a number


def _parallel(threads: Union[int, Threads, None]) -> Any:
    if threads is None or threads == 1:
        return _ffi.NULL
    if not isinstance(threads, Threads):
        count = _whole(threads, "threads")
        threads = _teams.get(count) or _teams.setdefault(count, Threads(count))
    return threads._parallel


class _Driven:
    """The calls that a plan and a workspace of its have in common: a state that is stepped in either is driven there."""

    def _call_own(self, function: str, *arguments: Any) -> None:
        _call(getattr(_lib, self._PREFIX + function), self._handle, *arguments)

    def forget(self) -> None:
        """After a jump of the state: what its springs did in the last step is not carried on."""
        getattr(_lib, self._PREFIX + "forget")(self._handle)

    def set_pose(
        self, motion: int, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (0, 0, 0), jump: bool = False
    ) -> None:
        """Puts what follows motion `motion` there at the end of the next step: on its way in every sub-step, with its velocity.

        By a jump it is there when that step begins, and rests in it unless a target without jump follows; so below.
        """
        self._call_own("jump_pose" if jump else "set_pose", motion, _vector(translation), _vector(rotation))

    def set_places(self, kinematic: int, places: ArrayLike, jump: bool = False) -> None:
        """The particles of group `kinematic` are at these places, (n, 3), at the end of the next step."""
        keep = []
        self._call_own("jump_places" if jump else "set_places", kinematic, *_rows(places, "double", 3, keep))

    def set_skin(self, skin: int, points: ArrayLike, normals: Optional[ArrayLike] = None, jump: bool = False) -> None:
        """The points, and normals, of skin `skin` are these, (n, 3), at the end of the next step."""
        keep = []
        points, count = _rows(points, "double", 3, keep)
        if normals is not None:
            normals, other = _rows(normals, "double", 3, keep)
            if other != count:
                raise ValueError(f"{other} normals: must be {count}, one for each point")
        self._call_own("jump_skin" if jump else "set_skin", skin, points, _ffi.NULL if normals is None else normals, count)


_CONTACTS = ("plane", "sphere", "capsule", "box", "convex", "mesh")
_LISTS = (FORCES, _CONTACTS, ("grid", "springs"), ("distance", "on_point", "on_line"))


class Workspace(_Driven):
    """The memory that one state works in while a plan steps it; made by Plan.workspace(), for that plan and its clones.

    One may serve many states, one after the other. But networks by scheme sequential without theta carry on in it what the
    springs did in the last step: such a state should have one of its own.
    """

    _PREFIX = "dvdx_workspace_"

    def __init__(self, handle: Any) -> None:
        self._handle = _ffi.gc(handle, _lib.dvdx_workspace_destroy)

    def __repr__(self) -> str:
        return f"<dvdx.Workspace: {self.bytes} bytes>"

    @property
    def bytes(self) -> int:
        """Memory in bytes: 0 where the scene has neither networks, constraints, skins, pins nor bodies that move."""
        return int(_lib.dvdx_workspace_bytes(self._handle))


class Plan(_Driven):
    """A scene compiled for one step size, one precision and one instruction set; made by compile().

    Steps run without Python's lock, on one thread or, by step(..., threads=4), on several, with the same bits. Any number of
    threads of your own step states of their own with it, each with a clone() or a workspace(); where the scene has neither
    networks, constraints, skins nor motions nor values for each particle they need neither.
    """

    _PREFIX = "dvdx_plan_"

    def __init__(self, handle: Any, items: List[Tuple[str, Dict[str, Any]]], about: Dict[str, Any]) -> None:
        self._handle = _ffi.gc(handle, _lib.dvdx_plan_destroy)
        self._items, self._about = items, about
        self.tears_at: Dict[int, float] = {}
        """As Scene.tears_at: see run()."""

    def __repr__(self) -> str:
        kinds = ", ".join(kind for kind, _ in self._items) or "nothing"
        precision = "float64" if _lib.dvdx_plan_precision(self._handle) == _lib.DVDX_FLOAT64 else "float32"
        return f"<dvdx.Plan: {kinds}; {precision}, step {self.step_size:g} s, {self.isa}>"

    @property
    def scene(self) -> Scene:
        """A copy of the scene that the plan steps, with what was changed since it was compiled."""
        handle = _ffi.new("dvdx_scene**")
        self._call_own("scene", handle)
        scene = Scene.__new__(Scene)
        scene._take(handle[0], dict(self._about), list(self._items))
        scene.step = self.step_size
        return scene

    def clone(self) -> Plan:
        """A plan for another state of the same scene: nothing is compiled again, and a later change of one leaves the other."""
        clone = _ffi.new("dvdx_plan**")
        self._call_own("clone", clone)
        other = Plan(clone[0], list(self._items), self._about)
        other.tears_at = dict(self.tears_at)
        return other

    def instance(self, state: State) -> Instance:
        """A state with all that belongs to it: a hundred characters are a hundred of these and one plan."""
        handle = _ffi.new("dvdx_instance**")
        _call(_lib.dvdx_instance_create, self._handle, state._struct, handle)
        return Instance(handle[0], state)

    def workspace(self) -> Workspace:
        """Memory for another state, for step(): it goes on with the plan's changes, which a clone does not."""
        workspace = _ffi.new("dvdx_workspace**")
        _call(_lib.dvdx_workspace_create, self._handle, workspace)
        return Workspace(workspace[0])

    def step(
        self, state: State, steps: int = 1, contacts: Optional[ContactReport] = None, workspace: Optional[Workspace] = None,
        threads: Union[int, Threads, None] = None,
    ) -> None:  # fmt: skip
        """Moves every particle of the state by so many steps, where it lies, and the state's time.

        contacts: a ContactReport, which is told what the scene's contacts do. workspace: None is the plan's own. threads: how
        many, or Threads; the bits do not depend on them.
        """
        report = _ffi.NULL if contacts is None else contacts._handle
        steps, parallel = _whole(steps, "steps"), _parallel(threads)
        if workspace is not None:
            self._call_own("step_in", workspace._handle, state._struct, steps, parallel, report)
        elif contacts is not None:
            self._call_own("step_and_report", state._struct, steps, parallel, report)
        else:
            self._call_own("step", state._struct, steps, parallel)

    def record(
        self, state: State, steps: int, every: int = 1, workspace: Optional[Workspace] = None,
        threads: Union[int, Threads, None] = None,
    ) -> Recording:  # fmt: skip
        """Makes so many steps, and keeps the state as it is now and after every `every` of them: see Recording.

            plan.record(state, steps=300, every=2).save("flag.html")
        """
        steps, every = _whole(steps, "steps"), _whole(every, "every", 1)
        recording = Recording(len(state), state.arrays["x"].dtype, steps // every + 1, every, self._items)
        recording.keep(0, state.time, state.positions, state.velocities, self.energy(state).total)
        for kept in range(1, steps // every + 1):
            self.run(state, every, workspace=workspace, threads=threads)
            recording.keep(kept, state.time, state.positions, state.velocities, self.energy(state).total)
        self.run(state, steps % every, workspace=workspace, threads=threads)
        return recording

    def run(
        self, state: State, steps: int = 1, workspace: Optional[Workspace] = None, threads: Union[int, Threads, None] = None
    ) -> int:
        """step(), and after each step springs tear that are longer than tears_at says, as in `dvdx run`: how many those were."""
        steps = _whole(steps, "steps")
        if not self.tears_at:
            self.step(state, steps, workspace=workspace, threads=threads)
            return 0
        torn = 0
        for _ in range(steps):
            self.step(state, 1, workspace=workspace, threads=threads)
            torn += sum(self.tear(state, stretch, network) for network, stretch in self.tears_at.items())
        return torn

    def energy(self, state: State) -> Energy:
        """J. Springs to anchors, drag and forces that depend on time have no part in it."""
        found = self.check(state)
        return Energy(found["kinetic"], found["elastic"], found["weight"])

    def seek(self, state: State, steps: int) -> None:
        """The same motion by powers of the step's matrix, where the scene allows it."""
        _call(_lib.dvdx_plan_seek, self._handle, state._struct, _whole(steps, "steps"))

    def carried(self, state: State, workspace: Optional[Workspace] = None) -> Array:
        """All that the next step depends on beside the state's columns and its time, an array of numbers for restore() alone.

        That is what the springs did in the last step, where it is carried on, and what is driven. With it a state that was
        stored goes on with the same bits in another plan of the same scene, compiled for the same start. workspace: as step().
        """
        function, own = ("carried", ()) if workspace is None else ("carried_in", (workspace._handle,))
        count = _ffi.new("size_t*")
        self._call_own(function, *own, state._struct, _ffi.NULL, 0, count)
        numbers = np.zeros(count[0])
        self._call_own(function, *own, state._struct, _ffi.from_buffer("double[]", numbers), len(numbers), count)
        return numbers

    def restore(self, carried: ArrayLike, state: State, workspace: Optional[Workspace] = None) -> None:
        """For the state as it was then: count, numbers and time. Changes nothing where it fails."""
        function, own = ("restore", ()) if workspace is None else ("restore_in", (workspace._handle,))
        keep = []
        self._call_own(function, *own, *_rows(carried, "double", None, keep), state._struct)

    def teleport(
        self, state: State, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (0, 0, 0),
        workspace: Optional[Workspace] = None,
    ) -> None:  # fmt: skip
        """Carries the state elsewhere, x to R x + translation, with all that follows motions or is driven.

        Nothing has another speed than before. Contacts that follow no motion, anchors and the directions of forces stay.
        rotation: about the world's origin. workspace: as in step().
        """
        function, own = ("teleport", ()) if workspace is None else ("teleport_in", (workspace._handle,))
        self._call_own(function, *own, state._struct, _vector(translation), _vector(rotation))

    def check(self, state: State) -> Dict[str, Any]:
        """How the state stands, as a dict of dvdx_state_check: stretch of springs, rods, energy, what is not finite."""
        return _checked(_lib.dvdx_plan_check, self._handle, state._struct)

    def meetings(self, workspace: Optional[Workspace] = None) -> Dict[str, Any]:
        """How particles met in the last sub-step, as a dict of dvdx_meetings; of a state that was stepped in a workspace: there."""
        meetings = _ffi.new("dvdx_meetings*")
        self._call_own("meetings", _ffi.NULL if workspace is None else workspace._handle, meetings)
        return {name: getattr(meetings, name) for name, _ in _ffi.typeof("dvdx_meetings").fields}

    def set_step(self, step: float) -> None:
        """Another step, s; with most_substeps in the coupling the longest that these keep stable: step_size says which."""
        _call(_lib.dvdx_plan_set_step, self._handle, step)

    def set_force(self, index: int, scene: Scene, force: int = 0) -> None:
        """The plan's force `index` becomes force `force` of a scene."""
        _call(_lib.dvdx_plan_replace, self._handle, index, scene._handle, force)
        self._replace_item(FORCES, index, scene, force)

    def set_contact(self, index: int, scene: Scene, contact: int = 0) -> None:
        """The plan's contact `index` becomes contact `contact` of a scene."""
        _call(_lib.dvdx_plan_replace_contact, self._handle, index, scene._handle, contact)
        self._replace_item(_CONTACTS, index, scene, contact)

    def _replace_item(self, kinds: Tuple[str, ...], index: int, scene: Scene, other: int) -> None:
        places = [at for at, (kind, _) in enumerate(self._items) if kind in kinds]
        self._items[places[index]] = [item for item in scene._items if item[0] in kinds][other]

    def replace(self, index: int, scene: Scene, force: int = 0) -> None:
        """Deprecated: set_force()."""
        warnings.warn("Plan.replace is now Plan.set_force", DeprecationWarning, stacklevel=2)
        self.set_force(index, scene, force)

    def replace_contact(self, index: int, scene: Scene, contact: int = 0) -> None:
        """Deprecated: set_contact()."""
        warnings.warn("Plan.replace_contact is now Plan.set_contact", DeprecationWarning, stacklevel=2)
        self.set_contact(index, scene, contact)

    def set_wind(self, mean: ArrayLike = (0, 0, 0), gusts: ArrayLike = ()) -> None:
        """The air's velocity, m/s; gusts: rows of amplitude, angular frequency (rad/s) and phase (rad), five numbers each."""
        keep = []
        wind = _struct("dvdx_wind", {"mean": mean, "gusts": np.reshape(gusts, (-1, 5))}, keep)
        _call(_lib.dvdx_plan_set_wind, self._handle, wind)

    def set_grid_stiffness(
        self, index: int = 0, structural: float = 0.0, shear: float = 0.0, bend: float = 0.0, damping: float = 0.0
    ) -> None:
        """Sets the stiffness of the plan's network `index`, a grid, N/m; damping in kg/s. Torn springs stay torn."""
        _call(_lib.dvdx_plan_set_grid_stiffness, self._handle, index, structural, shear, bend, damping)

    def set_springs_stiffness(self, stiffness: ArrayLike, index: int = 0, damping: float = 0.0) -> None:
        """Sets the stiffness of the plan's network `index`, a list: N/m, for all springs or one for each; damping in kg/s."""
        keep = []
        scalars = _ffi.new("dvdx_scalars*")
        _fill_scalars(scalars, stiffness, keep)
        _call(_lib.dvdx_plan_set_springs_stiffness, self._handle, index, scalars, damping)

    def set_bending(self, **keywords: Any) -> None:
        """By the keywords of Scene.bending: the network bends by these angles in place of all that it did before."""
        keep = []
        self._call_own("set_bending", _struct("dvdx_bending", keywords, keep))

    def set_mass(self, particle: int, mass: float) -> None:
        """kg, > 0"""
        _call(_lib.dvdx_plan_set_mass, self._handle, particle, mass)

    def fix(self, particle: int) -> None:
        """Holds a particle where the state has it."""
        _call(_lib.dvdx_plan_fix, self._handle, particle)

    def release(self, particle: int) -> None:
        """Lets a particle go, with the velocity that the state has."""
        _call(_lib.dvdx_plan_release, self._handle, particle)

    def break_spring(self, a: int, b: int, index: int = 0) -> None:
        """Tears what the plan's network `index` joins two particles by, for good."""
        _call(_lib.dvdx_plan_break_spring, self._handle, index, a, b)

    def tear(self, state: State, stretch: float, index: int = 0) -> int:
        """Tears every spring of the network that is longer than `stretch` times its rest length: how many those were."""
        torn = _ffi.new("size_t*")
        _call(_lib.dvdx_plan_tear, self._handle, index, stretch, state._struct, torn)
        return int(torn[0])

    @property
    def step_size(self) -> float:
        """s"""
        return float(_lib.dvdx_plan_step_size(self._handle))

    @property
    def isa(self) -> str:
        """The instruction set, in a word."""
        words = {value: word for word, value in _words(_ffi.typeof("dvdx_isa")).items()}
        return words[_lib.dvdx_plan_isa(self._handle)]

    def explain(self) -> str:
        """Tells what the scene needs, in words."""
        return _text(_lib.dvdx_plan_explain, self._handle)

    def network_limit(self) -> Optional[Dict[str, Any]]:
        """The limit of networks' sub-steps, as a dict of dvdx_network_limit; None for a scene without."""
        limit = _ffi.new("dvdx_network_limit*")
        if not _lib.dvdx_plan_network_limit(self._handle, limit):
            return None
        return {name: getattr(limit, name) for name, _ in _ffi.typeof("dvdx_network_limit").fields}


class Instance:
    """A state with what drives it, its wind, its frame time and what its springs carry on; made by Plan.instance().

        for positions in instance.play(seconds=5, fps=30):
            draw(positions)

    Any number of threads may step different instances of a plan at once.
    """

    def __init__(self, handle: Any, state: State) -> None:
        self._handle = _ffi.gc(handle, _lib.dvdx_instance_destroy)
        self.state = state
        """Its arrays are stepped, and its time goes on, by this instance alone."""

    def __repr__(self) -> str:
        return f"<dvdx.Instance: {len(self.state)} particles, step {self.step_size:g} s, time {self.state.time:g} s>"

    @property
    def step_size(self) -> float:
        """s"""
        return float(_lib.dvdx_instance_step_size(self._handle))

    def move_body(
        self, motion: int, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (0, 0, 0), jump: bool = False
    ) -> None:
        """All that follows motion `motion` is there at the end of the next step, or of the next advance(); by a jump at once."""
        _call(
            _lib.dvdx_instance_move_body, self._handle, motion, _vector(translation), _vector(rotation), _arrival(jump)
        )

    def move_pins(self, kinematic: int, places: ArrayLike, jump: bool = False) -> None:
        """Likewise the particles of group `kinematic`: places, (n, 3)."""
        keep: List[Any] = []
        _call(_lib.dvdx_instance_move_pins, self._handle, kinematic, *_rows(places, "double", 3, keep), _arrival(jump))

    def move_skin(self, skin: int, points: ArrayLike, normals: Optional[ArrayLike] = None, jump: bool = False) -> None:
        """Likewise the points, and normals, of skin `skin`, (n, 3)."""
        keep: List[Any] = []
        at, count = _rows(points, "double", 3, keep)
        directions = _ffi.NULL
        if normals is not None:
            directions, other = _rows(normals, "double", 3, keep)
            if other != count:
                raise ValueError(f"{other} normals: must be {count}, one for each point")
        _call(_lib.dvdx_instance_move_skin, self._handle, skin, at, directions, count, _arrival(jump))

    def set_wind(self, mean: ArrayLike = (0, 0, 0), gusts: ArrayLike = ()) -> None:
        """The air of this state alone: as Plan.set_wind()."""
        keep: List[Any] = []
        wind = _struct("dvdx_wind", {"mean": mean, "gusts": np.reshape(gusts, (-1, 5))}, keep)
        _call(_lib.dvdx_instance_set_wind, self._handle, wind)

    def step(self, step: Optional[float] = None, threads: Union[int, Threads, None] = None) -> None:
        """One step of this length, s: the frame time. None: as long as the last."""
        length = self.step_size if step is None else step
        _call(_lib.dvdx_instance_step, self._handle, length, _parallel(threads))
        self.state._struct.clock = _lib.dvdx_instance_clock(self._handle)

    def advance(self, frame_time: float, most: int = 8, threads: Union[int, Threads, None] = None) -> int:
        """Whole steps of the size that it has, as many as have become due, at most `most`: how many those were."""
        made = _ffi.new("size_t*")
        _call(_lib.dvdx_instance_advance, self._handle, frame_time, _whole(most, "most"), made, _parallel(threads))
        self.state._struct.clock = _lib.dvdx_instance_clock(self._handle)
        return int(made[0])

    def blend(self) -> Array:
        """Positions between the last two steps of advance(), (n, 3), for drawing."""
        drawn = State(*(np.zeros((len(self.state), 3), self.state.arrays["x"].dtype) for _ in range(2)))
        _call(_lib.dvdx_instance_blend, self._handle, drawn._struct)
        return drawn.positions

    def play(self, seconds: float, fps: float = 30) -> Iterator[Array]:
        """Positions of each frame, by advance() and blend()."""
        for _ in range(round(seconds * fps)):
            self.advance(1 / fps)
            yield self.blend()

    def teleport(self, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (0, 0, 0)) -> None:
        """Carries the state elsewhere with pins, bodies and skins: as Plan.teleport()."""
        _call(_lib.dvdx_instance_teleport, self._handle, _vector(translation), _vector(rotation))

    def check(self) -> Dict[str, Any]:
        """How the state stands: as Plan.check()."""
        return _checked(_lib.dvdx_instance_check, self._handle)


def step_all(
    instances: Sequence[Instance], frame_time: Union[float, Sequence[float]], threads: Union[int, Threads, None] = None
) -> None:
    """One step of each, none twice and all of one precision: as many at once as there are threads.

    frame_time: s, one or one for each.

    An error names the first that failed, as instances[k]; all others have stepped.
    """
    keep: List[Any] = []
    times, count = _rows(np.atleast_1d(frame_time), "double", None, keep)
    handles = _ffi.new("dvdx_instance*[]", [each._handle for each in instances])
    try:
        _call(_lib.dvdx_instances_step, handles, len(instances), times, count, _parallel(threads))
    finally:
        for each in instances:
            each.state._struct.clock = _lib.dvdx_instance_clock(each._handle)


def _arrival(jump: bool) -> int:
    return int(_lib.DVDX_JUMP if jump else _lib.DVDX_MOVING)


def _checked(function: Any, *arguments: Any) -> Dict[str, Any]:
    check = _ffi.new("dvdx_state_check*")
    _call(function, *arguments, check)
    found: Dict[str, Any] = {name: getattr(check, name) for name, _ in _ffi.typeof("dvdx_state_check").fields}
    return found | {name: tuple(found[name]) for name in ("spring", "rod")}


class ContactReport:
    """A record of a scene's contacts, step after step: ContactReport(contacts, events) keeps at most so many events."""

    _EVENT = np.dtype(
        [("step", np.uint64), ("time", float), ("particle", np.uintp), ("contact", np.uintp)]
        + [(name, float, 3) for name in ("x", "n", "impulse")]
    )

    def __init__(self, contacts: int, events: int = 0) -> None:
        self._room = np.zeros(_whole(events, "events"), self._EVENT)
        room = _ffi.from_buffer("dvdx_contact_event[]", self._room) if events else _ffi.NULL
        handle = _ffi.new("dvdx_contact_report**")
        _call(_lib.dvdx_contact_report_create, _whole(contacts, "contacts"), room, events, handle)
        self._handle = _ffi.gc(handle[0], _lib.dvdx_contact_report_destroy)
        self._contacts = contacts

    def __repr__(self) -> str:
        return f"<dvdx.ContactReport: {self._contacts} contacts, {len(self.events)} events, {self.lost} lost>"

    @property
    def sums(self) -> List[Dict[str, Any]]:
        """Each contact's hits, impulse (N s) and torque_impulse (N m s), of all particles and all steps so far."""
        sums = []
        for contact in range(self._contacts):
            in_c = _ffi.new("dvdx_contact_sum*")
            _call(_lib.dvdx_contact_report_sum, self._handle, contact, in_c)
            vectors = {name: np.array(list(getattr(in_c, name))) for name in ("impulse", "torque_impulse")}
            sums.append({"hits": in_c.hits, **vectors})
        return sums

    @property
    def events(self) -> Array:
        """Impacts, a row each of step, time, particle, contact, x, n, impulse, in the order of step, particle, time: a copy."""
        return self._room[: _lib.dvdx_contact_report_events(self._handle)].copy()

    @property
    def lost(self) -> int:
        """Events that found no room."""
        return int(_lib.dvdx_contact_report_lost(self._handle))

    def clear_events(self) -> None:
        """From now on there are none; the sums stay."""
        _lib.dvdx_contact_report_clear_events(self._handle)

    def clear(self) -> None:
        """From now on there are no events, and all sums are 0."""
        _lib.dvdx_contact_report_clear(self._handle)


class _LiveDriven:
    """The calls that a live plan and a workspace of its have in common."""

    _PREFIX: str
    _handle: Any

    def set_pose(
        self, motion: int, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (0, 0, 0), jump: bool = False
    ) -> None:
        """Puts contacts and emitters that follow motion `motion` there at the end of the next step: as Plan.set_pose()."""
        function = getattr(_lib, self._PREFIX + ("jump_pose" if jump else "set_pose"))
        _call(function, self._handle, motion, _vector(translation), _vector(rotation))


class LiveWorkspace(_LiveDriven):
    """The memory that one state works in while a live plan steps it, and what drives it; made by LifecyclePlan.workspace()."""

    _PREFIX = "dvdx_live_workspace_"

    def __init__(self, handle: Any) -> None:
        self._handle = _ffi.gc(handle, _lib.dvdx_live_workspace_destroy)

    def __repr__(self) -> str:
        return f"<dvdx.LiveWorkspace: {self.bytes} bytes>"

    @property
    def bytes(self) -> int:
        """Memory in bytes."""
        return int(_lib.dvdx_live_workspace_bytes(self._handle))


class LifecyclePlan(_LiveDriven):
    """A plan for particles that come and go; made by compile_live(). Its calls are those of Plan, by the same names.

    Any number of threads of your own step states of their own with it, each with a clone() or a workspace().
    """

    _PREFIX = "dvdx_live_plan_"

    def __init__(self, handle: Any) -> None:
        self._handle = _ffi.gc(handle, _lib.dvdx_live_plan_destroy)

    def __repr__(self) -> str:
        return f"<dvdx.LifecyclePlan: step {self.step_size:g} s>"

    @property
    def step_size(self) -> float:
        """s"""
        return float(_lib.dvdx_live_plan_step_size(self._handle))

    def workspace(self) -> LiveWorkspace:
        """Working memory for step(), in which everything driven is where this plan has it."""
        workspace = _ffi.new("dvdx_live_workspace**")
        _call(_lib.dvdx_live_workspace_create, self._handle, workspace)
        return LiveWorkspace(workspace[0])

    def set_wind(self, mean: ArrayLike = (0, 0, 0), gusts: ArrayLike = ()) -> None:
        """As Plan.set_wind(), though nothing meets the air here."""
        keep: List[Any] = []
        wind = _struct("dvdx_wind", {"mean": mean, "gusts": np.reshape(gusts, (-1, 5))}, keep)
        _call(_lib.dvdx_live_plan_set_wind, self._handle, wind)

    def check(self, state: LiveState) -> Dict[str, Any]:
        """As Plan.check(), of the particles that live."""
        return _checked(_lib.dvdx_live_plan_check, self._handle, state._live)

    def step(
        self, state: LiveState, steps: int = 1, contacts: Optional[ContactReport] = None,
        threads: Union[int, Threads, None] = None, workspace: Optional[LiveWorkspace] = None,
    ) -> None:  # fmt: skip
        """Moves, removes and makes particles for so many steps: len(state) is then how many live.

        contacts: a ContactReport, in which a particle is known by its place when a step begins. threads, workspace: as Plan.step().
        """
        steps, parallel = _whole(steps, "steps"), _parallel(threads)
        if workspace is not None:
            report = _ffi.NULL if contacts is None else contacts._handle
            _call(
                _lib.dvdx_live_plan_step_in, self._handle, workspace._handle, state._live, steps, parallel, report
            )
        elif contacts is None:
            _call(_lib.dvdx_live_plan_step, self._handle, state._live, steps, parallel)
        else:
            _call(_lib.dvdx_live_plan_step_and_report, self._handle, state._live, steps, parallel, contacts._handle)

    def clone(self) -> LifecyclePlan:
        """A plan for another state: nothing is compiled again."""
        clone = _ffi.new("dvdx_live_plan**")
        _call(_lib.dvdx_live_plan_clone, self._handle, clone)
        return LifecyclePlan(clone[0])

    def set_step(self, step: float) -> None:
        """Another step, s, > 0: births go on by time."""
        _call(_lib.dvdx_live_plan_set_step, self._handle, step)

    def set_force(self, index: int, scene: Scene, force: int = 0) -> None:
        """The plan's force `index` becomes force `force` of a scene."""
        _call(_lib.dvdx_live_plan_set_force, self._handle, index, scene._handle, force)

    def set_contact(self, index: int, scene: Scene, contact: int = 0) -> None:
        """The plan's contact `index` becomes contact `contact` of a scene: it is there at once. A body that moves follows a motion."""
        _call(_lib.dvdx_live_plan_set_contact, self._handle, index, scene._handle, contact)

    def set_emitter(self, index: int, emitter: Dict[str, Any]) -> None:
        """Emitter `index` becomes this one from the next step on; a rate of 0 switches it off."""
        keep: List[Any] = []
        _call(_lib.dvdx_live_plan_set_emitter, self._handle, index, _struct("dvdx_emitter", _emitter(emitter), keep))

    def burst(self, state: LiveState, births: int, emitter: int = 0, workspace: Optional[LiveWorkspace] = None) -> None:
        """So many births of an emitter at once, behind all that live."""
        if workspace is None:
            _call(_lib.dvdx_live_plan_burst, self._handle, state._live, emitter, _whole(births, "births"))
        else:
            at = workspace._handle
            _call(_lib.dvdx_live_plan_burst_in, self._handle, at, state._live, emitter, _whole(births, "births"))

    def remove(self, state: LiveState) -> None:
        """Removes what is to go as it stands; to remove one of your own choice, make its age infinite."""
        _call(_lib.dvdx_live_plan_remove, self._handle, state._live, _ffi.NULL)

    def teleport(
        self, state: LiveState, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (0, 0, 0),
        workspace: Optional[LiveWorkspace] = None,
    ) -> None:  # fmt: skip
        """As Plan.teleport(), of the particles that live and of what follows a motion. All else stays where it is."""
        by = _vector(translation), _vector(rotation)
        if workspace is None:
            _call(_lib.dvdx_live_plan_teleport, self._handle, state._live, *by)
        else:
            _call(_lib.dvdx_live_plan_teleport_in, self._handle, workspace._handle, state._live, *by)

    def explain(self) -> str:
        """Tells what the scene needs, and what coming and going costs, in words."""
        return _text(_lib.dvdx_live_plan_explain, self._handle)


LivePlan = LifecyclePlan  # its name of the last release


def _structs(kind: str, dicts: Sequence[Dict[str, Any]], keep: List[Any]) -> Tuple[Any, int]:
    """A C array of structs."""
    array = _ffi.new(f"{kind}[]", len(dicts))
    for i, keywords in enumerate(dicts):
        try:
            array[i] = _struct(kind, keywords, keep)[0]
        except (ValueError, TypeError) as fault:
            raise type(fault)(f"{kind.removeprefix('dvdx_')} {i}: {fault}") from None
    keep.append(array)
    return array, len(dicts)


def _emitter(given: Dict[str, Any]) -> Dict[str, Any]:
    """An emitter in C, where motions are counted from 1."""
    motion = given.get("motion")
    rest = {name: value for name, value in given.items() if name != "motion"}
    return rest if motion is None else rest | {"follows": _whole(motion, "motion") + 1}


def compile_live(
    scene: Scene, state: LiveState, emitters: Optional[Sequence[Dict[str, Any]]] = None,
    boundaries: Optional[Sequence[Dict[str, Any]]] = None, inside: Optional[ArrayLike] = None,
    not_finite: Optional[Literal["kept", "removed"]] = None, step: Optional[float] = None,
    order: Optional[Literal["kept", "any"]] = None, **options: Any,
) -> LifecyclePlan:  # fmt: skip
    """A plan for particles that come and go, at most as many as the arrays of the LiveState have room for.

    What is not given is that of the scene's file where it was loaded from one; else nothing, "kept", and a step of 1/60 s.

    emitters: dicts with the fields of dvdx_emitter (shape="disc", at=(0, 1, 0), normal=(0, 1, 0), radius=0.1, rate=1000, ...), and
    motion: the number of the scene's motion that carries it.
    boundaries: dicts with normal and offset: particles are removed where normal . x < offset. inside: ((x, y, z) least, (x, y,
    z) most): they are removed outside of it. not_finite: "kept" or "removed". order of those that
    stay: "kept", or "any": births and the last fill the holes. options as those of compile(). Balls of one radius meet
    (Scene.meet), without groups and with the order kept.
    """
    keep: List[Any] = []
    given = {"emitters": emitters, "boundaries": boundaries, "inside": inside, "not_finite": not_finite, "order": order}
    chosen = {**(scene.turnover or {}), **{name: value for name, value in given.items() if value is not None}}
    if step is None:
        step = scene.step if scene.step is not None else 1 / 60
    removal = {name: chosen[name] for name in ("not_finite", "order", "inside") if name in chosen}
    turnover = _struct("dvdx_turnover", removal, keep)
    made = [_emitter(each) for each in chosen.get("emitters", ())]
    turnover.emitters, turnover.emitter_count = _structs("dvdx_emitter", made, keep)
    turnover.boundaries, turnover.boundary_count = _structs("dvdx_boundary", chosen.get("boundaries", ()), keep)
    turnover.capacity = len(state.arrays["x"])
    handle = _ffi.new("dvdx_live_plan**")
    _call(_lib.dvdx_live_plan_create, scene._handle, turnover, _options(state, step, options), handle)
    return LifecyclePlan(handle[0])


def _options(state: State, step: float, options: Dict[str, Any]) -> Any:
    in_c = _struct("dvdx_options", {"step": step, **{name: value for name, value in options.items() if value is not None}}, [])
    in_c.precision = state._struct.precision
    return in_c


def compile(  # noqa: A001: the library's own word
    scene: Scene, state: State, step: Optional[float] = None, *,
    isa: Optional[Literal["reference", "sse2", "avx2", "avx512", "neon64"]] = None,
    arithmetic: Literal["separate", "contracted", "fast"] = "separate", block: int = 0,
    rounding: Literal["plain", "compensated"] = "plain", impacts: int = 0,
) -> Plan:  # fmt: skip
    """A plan for a scene and the particles of a state, in the precision of its arrays.

    step: s, negative runs time backwards; None: that of the scene's file, else 1/60. isa: the best where none is named.
    rounding: "compensated", for states with residuals. The others as in dvdx_options.
    """
    if step is None:
        step = scene.step if scene.step is not None else 1 / 60
    options = {"isa": isa, "arithmetic": arithmetic, "block": block, "rounding": rounding, "impacts": impacts}
    handle = _ffi.new("dvdx_plan**")
    _call(_lib.dvdx_plan_create, scene._handle, _options(state, step, options), state._struct, handle)
    plan = Plan(handle[0], list(scene._items), scene._about)
    plan.tears_at = dict(scene.tears_at)
    return plan


def grid_normals(state: State, rows: int, columns: int, first: int = 0) -> Array:
    """Normals of the sheet of particles first + row * columns + column, (rows, columns, 3), for drawing."""
    return _normals(state, rows * columns, _lib.dvdx_grid_normals, rows, columns, first).reshape(rows, columns, 3)


def triangle_normals(state: State, triangles: ArrayLike) -> Array:
    """Normals of all particles, (n, 3), by triangles (m, 3) of their numbers; zero where none is."""
    keep = []
    corners, count = _rows(triangles, "uint32_t", 3, keep)
    return _normals(state, len(state), _lib.dvdx_triangle_normals, corners, count)


def _normals(state: State, count: int, function: Any, *arguments: Any) -> Array:
    normals = np.zeros((count, 3), np.float64 if state._struct.precision == _lib.DVDX_FLOAT64 else np.float32)
    to = _ffi.new("dvdx_column[3]")
    for axis in range(3):
        to[axis].base = _ffi.cast("char*", _ffi.from_buffer(normals)) + axis * normals.itemsize
        to[axis].stride, to[axis].run, to[axis].capacity = normals.strides[0], 1, count
    _call(function, *arguments, state._struct, to)
    return normals


def bounds(state: State) -> Tuple[Array, Array]:
    """The box that holds the particles whose place is finite: least and most, (3,) each."""
    box = _ffi.new("dvdx_bounds*")
    _call(_lib.dvdx_state_bounds, state._struct, box)
    return np.array(list(box.least)), np.array(list(box.most))


def build_info() -> str:
    """Version, compiler and instruction sets of the library, in a line."""
    return _text(_lib.dvdx_build_info)


def report(
    *scenes: Union[str, "os.PathLike[str]"], quick: bool = False, precision: Optional[str] = None,
    threads: Optional[int] = None,
) -> Dict[str, Any]:  # fmt: skip
    """The measurements of `dvdx report SCENE... --json`, as a dict: speed against error of every method.

    The command is the one that DVDX_COMMAND names, else that beside the library, else `dvdx` on PATH. precision: float32,
    float64 or both.
    """
    with tempfile.TemporaryDirectory() as folder:
        line: List[str] = [command(), "report", *map(os.fspath, scenes), "--json", "--out", folder]
        line += ["--quick"] if quick else []
        line += ["--precision", precision] if precision else []
        line += ["--threads", str(threads)] if threads else []
        told = subprocess.run(line, capture_output=True, text=True, check=False)
    if told.returncode != 0:
        raise DvdxError(told.stderr.strip())
    measured: Dict[str, Any] = json.loads(told.stdout)
    return measured
