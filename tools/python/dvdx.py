"""Steps particles that lie in NumPy arrays, by dvdx's C API; nothing is copied.

    scene = dvdx.Scene()
    scene.constant(acceleration=(0, -9.81, 0))
    scene.plane(normal=(0, 1, 0), restitution=0.4)
    state = dvdx.State(positions, velocities)  # two (n, 3) arrays, six columns or one structured array
    plan = dvdx.compile(scene, state, step=1 / 60)
    plan.step(state, 60)                       # positions and velocities have moved

SI units; names, units and ranges are those of dvdx/scene.hpp. Needs Debian's python3-cffi and python3-numpy, and an installed
dvdx (header and shared library): the one under DVDX_PREFIX, else the one that this file was installed with, else the system's.
"""

import itertools
import json
import os
import pathlib
import re
import subprocess
import tempfile

import cffi
import numpy as np

COLUMNS = ("x", "y", "z", "vx", "vy", "vz")


def _load():
    """The installed header and library, in cffi's hands, and the number of the binary interface that they speak."""
    own = pathlib.Path(__file__).resolve().parents
    prefixes = [pathlib.Path(p) for p in (os.environ.get("DVDX_PREFIX"), *own[3:4], "/usr/local", "/usr") if p]
    for prefix in prefixes:
        include = prefix / "include/dvdx"
        libraries = [*prefix.glob("lib*/libdvdx.so"), *prefix.glob("lib/*/libdvdx.so")]
        if (include / "dvdx.h").exists() and libraries:
            header = (include / "dvdx.h").read_text(encoding="utf-8")
            version = (include / "version.h").read_text(encoding="utf-8")
            ffi = cffi.FFI()
            ffi.cdef(_declarations(header))
            return ffi, ffi.dlopen(str(libraries[0])), header, int(re.search(r"DVDX_ABI_VERSION (\d+)", version)[1])
    raise ImportError(f"no include/dvdx/dvdx.h and libdvdx.so under {', '.join(map(str, prefixes))}: set DVDX_PREFIX")


def _declarations(header):
    """The part of a C header that cffi can read: no comments, no preprocessor, nothing for C++."""
    text = re.sub(r"//[^\n]*", "", header)
    text = re.sub(r"^#ifdef __cplusplus.*?^#endif", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^#[^\n]*", "", text, flags=re.MULTILINE)
    return text.replace("DVDX_EXPORT", "")


_ffi, _lib, _header, _abi_version = _load()


class DvdxError(Exception):
    """An error in a scene, an option or a state: the field ("forces[2].stiffness"), its value, and what is valid."""

    def __init__(self, message, field="", value="", valid=""):
        super().__init__(message)
        self.field, self.value, self.valid = field, value, valid


def _call(function, *arguments):
    error = _ffi.new("dvdx_error*")
    if function(*arguments, error) != _lib.DVDX_DONE:
        raise DvdxError(*(_ffi.string(getattr(error, name)).decode() for name in ("message", "field", "value", "valid")))


def _text(function, *arguments):
    size = function(*arguments, _ffi.NULL, 0) + 1
    text = _ffi.new("char[]", size)
    function(*arguments, text, size)
    return _ffi.string(text).decode()


# ---- Python's values to C's structs, by the types that the header gives to their fields ------------------------------------


def _words(enum):
    """{"curve": 0, "line": 1} of dvdx_sweep {DVDX_SWEEP_CURVE, DVDX_SWEEP_LINE}"""
    prefix = f"{enum.cname.removeprefix('enum ')}_".upper()
    return {name.removeprefix(prefix).removeprefix("DVDX_").lower(): value for value, name in sorted(enum.elements.items())}


def _choice(enum, word):
    words = _words(enum)
    if word not in words:
        raise ValueError(f"{word!r}: must be one of {', '.join(words)}")
    return words[word]


def _rows(value, kind, width, keep):
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


def _vector(value):
    if np.shape(value) != (3,):
        raise ValueError(f"shape {np.shape(value)}: must be three numbers")
    return [float(number) for number in value]


def _array(value, field):
    """The numbers of a fixed array: a vector, a few numbers, or a few vectors."""
    if field.length == 3:
        return _vector(value)
    if len(value) != field.length:
        raise ValueError(f"{len(value)} values: must be {field.length}")
    return [_vector(each) if field.item.kind == "array" else float(each) for each in value]


def _fill_scalars(struct, value, keep):
    if np.ndim(value) == 0:
        struct.all = value
    else:
        struct.each, struct.count = _rows(value, "double", None, keep)


def _fill_per_axis(struct, value, keep):
    if isinstance(value, (tuple, list)):
        struct.axes, count = _rows(value, "double", None, keep)
        if count != 3:
            raise ValueError(f"{count} numbers: must be one, three (one an axis) or an array with one a particle")
    else:
        _fill_scalars(struct, value, keep)


def _fill_anchor(struct, value, keep):
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
# What counts the rows of a list that has not its struct's own count.
_COUNTS = {"triangles": "triangle_count", "meet": "pair_count"}
_FILL = {"dvdx_scalars": _fill_scalars, "dvdx_per_axis": _fill_per_axis, "dvdx_anchor": _fill_anchor}


def _fill_field(struct, name, field, value, keep):
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


def _fields(kind):
    """Every keyword of a struct, with the types on the way to it: a surface's are those of the contact that has it."""
    fields = {}
    for name, field in _ffi.typeof(kind).fields:
        if name == "surface":
            fields |= {inner: ("surface", type_) for inner, (_, type_) in _fields(field.type.cname).items()}
        elif name not in ("count", "terms", *_COUNTS.values()):
            fields[name] = (None, field.type)
    return fields


def _struct(kind, keywords, keep):
    struct, fields = _ffi.new(f"{kind}*"), _fields(kind)
    for name, value in keywords.items():
        if name not in fields:
            raise TypeError(f"{kind.removeprefix('dvdx_')} has no {name}: there are {', '.join(fields)}")
        inside, field = fields[name]
        try:
            _fill_field(getattr(struct, inside) if inside else struct, name, field, value, keep)
        except (ValueError, TypeError, OverflowError) as fault:
            raise type(fault)(f"{name}: {fault}") from None
    return struct


# ---- Scenes ----------------------------------------------------------------------------------------------------------------


class Scene:
    """The contents of the world. One method for each force, contact, network and constraint of dvdx.h, with the names of its fields:

    constant, polynomial, sinusoid, spring, radial_spring, drag; plane, sphere, capsule, box, convex, mesh; grid, springs; distance, on_point, on_line;
    motion, kinematic; skin, tethers. A motion's keys are rows of time, translation and rotation vector, seven numbers each.
    aerodynamics(network=0, density=1.2, drag=1, lift=0.5) lets a network meet the air; springs take triangles, rows of three
    particles. bending(network=0, modulus=..., triangles=..., flat=...) makes springs bend by the angles across edges, flat being
    a point for each particle. wind(mean=..., gusts=...): rows of amplitude, angular frequency and phase, five numbers each.
    skin(particles=..., points=..., at_most=...) keeps particles near points that move, backstop(skin=0, normals=..., offset=...,
    radius=...) out of a ball behind each of them; tethers(network=0, stretch=1.02) keeps a network near what it hangs on.
    meet(radius=...) makes particles balls that meet, meet(thickness=...) keeps networks' particles apart; then meet_groups(of=...,
    meet=[(0, 1)]) says which do: a group for each particle, and pairs of groups.
    Choices are words (method="pulse", sweep="line"). A stiffness, a mass or another number that particles may have each their
    own of is a number or an array; one for each axis is a tuple of three. An anchor is a point, an array of them, or "start".
    A capsule's radius is one number for each end; a convex body's planes are rows of normal and offset.
    coupling(...) says how networks and constraints are stepped. origin, a point or one for each particle: where a state's
    positions are measured from.
    """

    def __init__(self, method=None, mass=None, fixed=(), origin=None):
        keep, handle = [], _ffi.new("dvdx_scene**")
        _call(_lib.dvdx_scene_create, _abi_version, handle)
        self._handle = _ffi.gc(handle[0], _lib.dvdx_scene_destroy)
        if method is not None:
            _call(_lib.dvdx_scene_set_method, self._handle, _choice(_ffi.typeof("dvdx_method"), method))
        if mass is not None:
            scalars = _ffi.new("dvdx_scalars*")
            _fill_scalars(scalars, mass, keep)
            _call(_lib.dvdx_scene_set_mass, self._handle, scalars)
        if len(fixed):
            _call(_lib.dvdx_scene_set_fixed, self._handle, *_rows(np.unique(fixed), "size_t", None, keep))
        if origin is not None:
            _call(_lib.dvdx_scene_set_origin, self._handle, *_rows(np.atleast_2d(origin), "double", 3, keep))


    def contact_motion(self, contact, motion):
        """Contact `contact` follows motion `motion`, both counted from 0."""
        _call(_lib.dvdx_scene_set_contact_motion, self._handle, contact, motion)
        return self

    def jump(self, motion, key):
        """No way leads to key `key` of motion `motion` from the key before, both counted from 0: there it jumps."""
        _call(_lib.dvdx_scene_set_jump, self._handle, motion, key)
        return self

    def skin_motion(self, skin, motion):
        """Skin `skin` follows motion `motion`, both counted from 0."""
        _call(_lib.dvdx_scene_set_skin_motion, self._handle, skin, motion)
        return self


def _scene_method(function, kind):
    def add(self, **keywords):
        keep = []
        _call(getattr(_lib, function), self._handle, _struct(kind, keywords, keep))
        return self

    add.__name__ = kind.removeprefix("dvdx_")
    add.__qualname__ = f"Scene.{add.__name__}"
    add.__doc__ = f"{add.__name__}({', '.join(_fields(kind))}), by keywords; what is left out is 0 or the default."
    return add


for _function, _kind in re.findall(r"(dvdx_scene_(?:add_|set_)\w+)\(dvdx_scene\* scene, const (dvdx_\w+)\* (?!mass)", _header):
    setattr(Scene, _kind.removeprefix("dvdx_"), _scene_method(_function, _kind))


# ---- Particles -------------------------------------------------------------------------------------------------------------


def _numbers(array, what):
    """A column that dvdx reads must be float32 or float64 in memory, writable and aligned."""
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{what} is {type(array).__name__}: must be a numpy.ndarray, whose memory is stepped")
    if array.dtype not in (np.float32, np.float64):
        raise TypeError(f"{what} is of {array.dtype}: must be float32 or float64 in native byte order")
    if not array.flags.writeable or not array.flags.aligned:
        raise ValueError(f"{what} is read-only or not aligned: its memory cannot be stepped")
    return array


def _columns_of(arrays):
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


def _column(in_c, column):
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

    def __init__(self, *arrays, time=0.0, rests=()):
        columns = _columns_of(arrays)
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

    def __len__(self):
        return self._struct.count

    @property
    def time(self):
        """The scene's time, s."""
        return self._struct.clock.seconds

    @property
    def clock(self):
        """The same as a sum of two, which is what a state's next step depends on."""
        return self._struct.clock.seconds, self._struct.clock.carry

    def hash(self):
        """FNV-1a over all numbers' bits, 64 bits: the state_hash of `dvdx run --json`, as 16 hexadecimal digits."""
        return f"{_lib.dvdx_state_hash(self._struct):016x}"


class LiveState(State):
    """Particles that come and go: arrays as long as the most that may live at once, of which the first len(state) live.

    LiveState(positions, velocities, count=0, age=..., lifetime=..., carried=(ids, ...)): age and lifetime (s) are 1-D arrays of
    the same kind as the columns, or left out; carried are 1-D arrays of any kind whose elements go along with the particles.
    """

    def __init__(self, *arrays, count=0, age=None, lifetime=None, carried=(), time=0.0):
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
    def born(self):
        """So far, by the emitters."""
        return self._live.born

    @property
    def removed(self):
        """So far."""
        return self._live.removed

    @property
    def dropped(self):
        """Births that found no room."""
        return self._live.dropped


# ---- Plans -----------------------------------------------------------------------------------------------------------------


class _Driven:
    """The calls that a plan and a workspace of its have in common: a state that is stepped in either is driven there."""

    def _call_own(self, function, *arguments):
        _call(getattr(_lib, self._PREFIX + function), self._handle, *arguments)

    def forget(self):
        """After a jump of the state: what its springs did in the last step is not carried on."""
        getattr(_lib, self._PREFIX + "forget")(self._handle)

    def set_pose(self, motion, translation=(0, 0, 0), rotation=(0, 0, 0), jump=False):
        """Puts what follows motion `motion` there at the end of the next step: on its way in every sub-step, with its velocity.

        By a jump it is there when that step begins, and rests in it unless a target without jump follows; so below.
        """
        self._call_own("jump_pose" if jump else "set_pose", motion, _vector(translation), _vector(rotation))

    def set_places(self, kinematic, places, jump=False):
        """The particles of group `kinematic` are at these places, (n, 3), at the end of the next step."""
        keep = []
        self._call_own("jump_places" if jump else "set_places", kinematic, *_rows(places, "double", 3, keep))

    def set_skin(self, skin, points, normals=None, jump=False):
        """The points, and normals, of skin `skin` are these, (n, 3), at the end of the next step."""
        keep = []
        points, count = _rows(points, "double", 3, keep)
        if normals is not None:
            normals, other = _rows(normals, "double", 3, keep)
            if other != count:
                raise ValueError(f"{other} normals: must be {count}, one for each point")
        self._call_own("jump_skin" if jump else "set_skin", skin, points, _ffi.NULL if normals is None else normals, count)


class Workspace(_Driven):
    """The memory that one state works in while a plan steps it; made by Plan.workspace(), for that plan and its clones.

    One may serve many states, one after the other. But networks by scheme sequential without theta carry on in it what the
    springs did in the last step: such a state should have one of its own.
    """

    _PREFIX = "dvdx_workspace_"

    def __init__(self, handle):
        self._handle = _ffi.gc(handle, _lib.dvdx_workspace_destroy)

    @property
    def bytes(self):
        """Memory in bytes: 0 where the scene has no networks, constraints, skins, kinematic particles and contacts that move."""
        return _lib.dvdx_workspace_bytes(self._handle)


class Plan(_Driven):
    """A scene compiled for one step size, one precision and one instruction set; made by compile().

    Steps are serial and run without Python's lock. For more threads, give each its own slice of the particles: a state of
    x[a:b], ... and the same plan, where the scene has neither networks nor constraints nor values for each particle. The bits
    are those of one call. Other plans step any number of states on any number of threads, each with a clone() or a workspace().
    """

    _PREFIX = "dvdx_plan_"

    def __init__(self, handle):
        self._handle = _ffi.gc(handle, _lib.dvdx_plan_destroy)

    def clone(self):
        """A plan for another state of the same scene: nothing is compiled again, and a later change of one leaves the other."""
        clone = _ffi.new("dvdx_plan**")
        self._call_own("clone", clone)
        return Plan(clone[0])

    def workspace(self):
        """Memory for another state, for step(): it goes on with the plan's changes, which a clone does not."""
        workspace = _ffi.new("dvdx_workspace**")
        _call(_lib.dvdx_workspace_create, self._handle, workspace)
        return Workspace(workspace[0])

    def step(self, state, steps=1, contacts=None, workspace=None):
        """Moves every particle of the state by so many steps, where it lies, and the state's time.

        contacts: a ContactReport, which is told what the scene's contacts do. workspace: None is the plan's own.
        """
        report = _ffi.NULL if contacts is None else contacts._handle
        if workspace is not None:
            self._call_own("step_in", workspace._handle, state._struct, steps, _ffi.NULL, report)
        elif contacts is not None:
            self._call_own("step_and_report", state._struct, steps, _ffi.NULL, report)
        else:
            self._call_own("step", state._struct, steps, _ffi.NULL)

    def seek(self, state, steps):
        """The same motion by powers of the step's matrix, where the scene allows it."""
        _call(_lib.dvdx_plan_seek, self._handle, state._struct, steps)

    def carried(self, state, workspace=None):
        """All that the next step depends on beside the state's columns and its time, an array of numbers for restore() alone.

        That is what the springs did in the last step, where it is carried on, and what is driven. With it a state that was stored
        goes on with the same bits in another plan of the same scene, compiled for the same start. workspace: as in step().
        """
        function, own = ("carried", ()) if workspace is None else ("carried_in", (workspace._handle,))
        count = _ffi.new("size_t*")
        self._call_own(function, *own, state._struct, _ffi.NULL, 0, count)
        numbers = np.zeros(count[0])
        self._call_own(function, *own, state._struct, _ffi.from_buffer("double[]", numbers), len(numbers), count)
        return numbers

    def restore(self, carried, state, workspace=None):
        """For the state as it was then: count, numbers and time. Changes nothing where it fails."""
        function, own = ("restore", ()) if workspace is None else ("restore_in", (workspace._handle,))
        keep = []
        self._call_own(function, *own, *_rows(carried, "double", None, keep), state._struct)

    def teleport(self, state, translation=(0, 0, 0), rotation=(0, 0, 0), workspace=None):
        """Carries the state elsewhere, x to R x + translation, with all that follows motions or is driven.

        Nothing has another speed than before. Contacts that follow no motion, anchors and the directions of forces stay.
        rotation: about the world's origin. workspace: as in step().
        """
        function, own = ("teleport", ()) if workspace is None else ("teleport_in", (workspace._handle,))
        self._call_own(function, *own, state._struct, _vector(translation), _vector(rotation))

    def check(self, state):
        """How the state stands, as a dict of dvdx_state_check: stretch of springs, rods, energy, what is not finite."""
        check = _ffi.new("dvdx_state_check*")
        self._call_own("check", state._struct, check)
        found = {name: getattr(check, name) for name, _ in _ffi.typeof("dvdx_state_check").fields}
        return found | {name: tuple(found[name]) for name in ("spring", "rod")}

    def meetings(self, workspace=None):
        """How particles met in the last sub-step, as a dict of dvdx_meetings; of a state that was stepped in a workspace: there."""
        meetings = _ffi.new("dvdx_meetings*")
        self._call_own("meetings", _ffi.NULL if workspace is None else workspace._handle, meetings)
        return {name: getattr(meetings, name) for name, _ in _ffi.typeof("dvdx_meetings").fields}

    def set_step(self, step):
        """Another step, s; with most_substeps in the coupling the longest that these keep stable: step_size says which."""
        _call(_lib.dvdx_plan_set_step, self._handle, step)

    def replace(self, index, scene, force=0):
        """The plan's force `index` becomes force `force` of a scene."""
        _call(_lib.dvdx_plan_replace, self._handle, index, scene._handle, force)

    def replace_contact(self, index, scene, contact=0):
        """The plan's contact `index` becomes contact `contact` of a scene."""
        _call(_lib.dvdx_plan_replace_contact, self._handle, index, scene._handle, contact)

    def set_wind(self, mean=(0, 0, 0), gusts=()):
        """The air's velocity, m/s; gusts: rows of amplitude, angular frequency (rad/s) and phase (rad), five numbers each."""
        keep = []
        wind = _struct("dvdx_wind", {"mean": mean, "gusts": np.reshape(gusts, (-1, 5))}, keep)
        _call(_lib.dvdx_plan_set_wind, self._handle, wind)

    def set_grid_stiffness(self, index=0, structural=0.0, shear=0.0, bend=0.0, damping=0.0):
        """Sets the stiffness of the plan's network `index`, a grid, N/m; damping in kg/s. Torn springs stay torn."""
        _call(_lib.dvdx_plan_set_grid_stiffness, self._handle, index, structural, shear, bend, damping)

    def set_springs_stiffness(self, stiffness, index=0, damping=0.0):
        """Sets the stiffness of the plan's network `index`, a list: one number for all springs or one for each, N/m; damping in kg/s."""
        keep = []
        scalars = _ffi.new("dvdx_scalars*")
        _fill_scalars(scalars, stiffness, keep)
        _call(_lib.dvdx_plan_set_springs_stiffness, self._handle, index, scalars, damping)

    def set_bending(self, **keywords):
        """By the keywords of Scene.bending: the network bends by these angles in place of all that it did before."""
        keep = []
        self._call_own("set_bending", _struct("dvdx_bending", keywords, keep))

    def set_mass(self, particle, mass):
        """kg, > 0"""
        _call(_lib.dvdx_plan_set_mass, self._handle, particle, mass)

    def fix(self, particle):
        """Holds a particle where the state has it."""
        _call(_lib.dvdx_plan_fix, self._handle, particle)

    def release(self, particle):
        """Lets a particle go, with the velocity that the state has."""
        _call(_lib.dvdx_plan_release, self._handle, particle)

    def break_spring(self, a, b, index=0):
        """Tears what the plan's network `index` joins two particles by, for good."""
        _call(_lib.dvdx_plan_break_spring, self._handle, index, a, b)

    def tear(self, state, stretch, index=0):
        """Tears every spring of the network that is longer than `stretch` times its rest length: how many those were."""
        torn = _ffi.new("size_t*")
        _call(_lib.dvdx_plan_tear, self._handle, index, stretch, state._struct, torn)
        return torn[0]

    @property
    def step_size(self):
        """s"""
        return _lib.dvdx_plan_step_size(self._handle)

    @property
    def isa(self):
        """The instruction set, in a word."""
        words = {value: word for word, value in _words(_ffi.typeof("dvdx_isa")).items()}
        return words[_lib.dvdx_plan_isa(self._handle)]

    def explain(self):
        """Tells what the scene needs, in words."""
        return _text(_lib.dvdx_plan_explain, self._handle)

    def network_limit(self):
        """The limit of networks' sub-steps, as a dict of dvdx_network_limit; None for a scene without."""
        limit = _ffi.new("dvdx_network_limit*")
        if not _lib.dvdx_plan_network_limit(self._handle, limit):
            return None
        return {name: getattr(limit, name) for name, _ in _ffi.typeof("dvdx_network_limit").fields}


class ContactReport:
    """A record of a scene's contacts, step after step: ContactReport(contacts, events) keeps at most so many events."""

    _EVENT = np.dtype(
        [("step", np.uint64), ("time", float), ("particle", np.uintp), ("contact", np.uintp)]
        + [(name, float, 3) for name in ("x", "n", "impulse")]
    )

    def __init__(self, contacts, events=0):
        self._room = np.zeros(events, self._EVENT)
        room = _ffi.from_buffer("dvdx_contact_event[]", self._room) if events else _ffi.NULL
        handle = _ffi.new("dvdx_contact_report**")
        _call(_lib.dvdx_contact_report_create, contacts, room, events, handle)
        self._handle = _ffi.gc(handle[0], _lib.dvdx_contact_report_destroy)
        self._contacts = contacts

    @property
    def sums(self):
        """Each contact's hits, impulse (N s) and torque_impulse (N m s), of all particles and all steps so far."""
        sums = []
        for contact in range(self._contacts):
            in_c = _ffi.new("dvdx_contact_sum*")
            _call(_lib.dvdx_contact_report_sum, self._handle, contact, in_c)
            vectors = {name: np.array(list(getattr(in_c, name))) for name in ("impulse", "torque_impulse")}
            sums.append({"hits": in_c.hits, **vectors})
        return sums

    @property
    def events(self):
        """Impacts, a row each of step, time, particle, contact, x, n, impulse, in the order of step, particle, time: a copy."""
        return self._room[: _lib.dvdx_contact_report_events(self._handle)].copy()

    @property
    def lost(self):
        """Events that found no room."""
        return _lib.dvdx_contact_report_lost(self._handle)

    def clear_events(self):
        """From now on there are none; the sums stay."""
        _lib.dvdx_contact_report_clear_events(self._handle)

    def clear(self):
        """From now on there are no events, and all sums are 0."""
        _lib.dvdx_contact_report_clear(self._handle)


class LivePlan:
    """A plan for particles that come and go; made by compile_live(). Steps one state at a time."""

    def __init__(self, handle):
        self._handle = _ffi.gc(handle, _lib.dvdx_live_plan_destroy)

    def step(self, state, steps=1, contacts=None):
        """Moves, removes and makes particles for so many steps: len(state) is then how many live.

        contacts: a ContactReport, in which a particle is known by its place when a step begins.
        """
        if contacts is None:
            _call(_lib.dvdx_live_plan_step, self._handle, state._live, steps, _ffi.NULL)
        else:
            _call(_lib.dvdx_live_plan_step_and_report, self._handle, state._live, steps, _ffi.NULL, contacts._handle)

    def remove(self, state):
        """Removes what is to go as it stands; to remove one of your own choice, make its age infinite."""
        _call(_lib.dvdx_live_plan_remove, self._handle, state._live, _ffi.NULL)

    def teleport(self, state, translation=(0, 0, 0), rotation=(0, 0, 0)):
        """As Plan.teleport(), of the particles that live. Emitters, boundaries and contacts stay where they are."""
        _call(_lib.dvdx_live_plan_teleport, self._handle, state._live, _vector(translation), _vector(rotation))

    def explain(self):
        """Tells what the scene needs, and what coming and going costs, in words."""
        return _text(_lib.dvdx_live_plan_explain, self._handle)


def _structs(kind, dicts, keep):
    """A C array of structs."""
    array = _ffi.new(f"{kind}[]", len(dicts))
    for i, keywords in enumerate(dicts):
        try:
            array[i] = _struct(kind, keywords, keep)[0]
        except (ValueError, TypeError, OverflowError) as fault:
            raise type(fault)(f"{kind.removeprefix('dvdx_')} {i}: {fault}") from None
    keep.append(array)
    return array, len(dicts)


def compile_live(
    scene, state, emitters=(), boundaries=(), inside=None, not_finite="kept", step=1 / 60, order="kept", **options
):
    """A plan for particles that come and go, at most as many as the arrays of the LiveState have room for.

    emitters: dicts with the fields of dvdx_emitter (shape="disc", at=(0, 1, 0), normal=(0, 1, 0), radius=0.1, rate=1000, ...).
    boundaries: dicts with normal and offset: particles are removed where normal . x < offset. inside: ((x, y, z) least, (x, y,
    z) most): they are removed outside of it. not_finite: "kept" or "removed". order of those that
    stay: "kept", or "any": births and the last fill the holes. options as those of compile().
    """
    keep = []
    removal = {"not_finite": not_finite, "order": order, **({} if inside is None else {"inside": inside})}
    turnover = _struct("dvdx_turnover", removal, keep)
    turnover.emitters, turnover.emitter_count = _structs("dvdx_emitter", emitters, keep)
    turnover.boundaries, turnover.boundary_count = _structs("dvdx_boundary", boundaries, keep)
    turnover.capacity = len(state.arrays["x"])
    handle = _ffi.new("dvdx_live_plan**")
    _call(_lib.dvdx_live_plan_create, scene._handle, turnover, _options(state, step, options), handle)
    return LivePlan(handle[0])


def _options(state, step, options):
    in_c = _struct("dvdx_options", {"step": step, **{name: value for name, value in options.items() if value is not None}}, [])
    in_c.precision = state._struct.precision
    return in_c


def compile(scene, state, step=1 / 60, **options):  # noqa: A001: the library's own word
    """A plan for a scene and the particles of a state, in the precision of its arrays; step in s, negative runs time backwards.

    options: isa ("reference", "sse2", "avx2", "avx512", "neon64"; the best where none is named), arithmetic ("separate",
    "contracted" or "fast"), block, impacts and rounding ("compensated", for states with residuals), as in dvdx_options.
    """
    handle = _ffi.new("dvdx_plan**")
    _call(_lib.dvdx_plan_create, scene._handle, _options(state, step, options), state._struct, handle)
    return Plan(handle[0])


def grid_normals(state, rows, columns, first=0):
    """Normals of the sheet of particles first + row * columns + column, (rows, columns, 3), for drawing."""
    return _normals(state, rows * columns, _lib.dvdx_grid_normals, rows, columns, first).reshape(rows, columns, 3)


def triangle_normals(state, triangles):
    """Normals of all particles, (n, 3), by triangles (m, 3) of their numbers; zero where none is."""
    keep = []
    corners, count = _rows(triangles, "uint32_t", 3, keep)
    return _normals(state, len(state), _lib.dvdx_triangle_normals, corners, count)


def _normals(state, count, function, *arguments):
    normals = np.zeros((count, 3), np.float64 if state._struct.precision == _lib.DVDX_FLOAT64 else np.float32)
    to = _ffi.new("dvdx_column[3]")
    for axis in range(3):
        to[axis].base = _ffi.cast("char*", _ffi.from_buffer(normals)) + axis * normals.itemsize
        to[axis].stride, to[axis].run, to[axis].capacity = normals.strides[0], 1, count
    _call(function, *arguments, state._struct, to)
    return normals


def bounds(state):
    """The box that holds the particles whose place is finite: least and most, (3,) each."""
    box = _ffi.new("dvdx_bounds*")
    _call(_lib.dvdx_state_bounds, state._struct, box)
    return np.array(list(box.least)), np.array(list(box.most))


def build_info():
    """Version, compiler and instruction sets of the library, in a line."""
    return _text(_lib.dvdx_build_info)


def report(*scenes, quick=False, precision=None, threads=None):
    """The measurements of `dvdx report SCENE... --json`, as a dict: speed against error of every method.

    The command is the one that DVDX_COMMAND names, else `dvdx` on PATH. precision: float32, float64 or both.
    """
    with tempfile.TemporaryDirectory() as folder:
        line = [os.environ.get("DVDX_COMMAND") or "dvdx", "report", *map(os.fspath, scenes), "--json", "--out", folder]
        line += ["--quick"] if quick else []
        line += ["--precision", precision] if precision else []
        line += ["--threads", str(threads)] if threads else []
        told = subprocess.run(line, capture_output=True, text=True, check=False)
    if told.returncode != 0:
        raise DvdxError(told.stderr.strip())
    return json.loads(told.stdout)
