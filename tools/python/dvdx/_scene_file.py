"""Scene files (dvdx-scene/1) as scenes: what Scene.load() reads. The command's own reader says more of a file that is wrong."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Type, Union

import numpy as np
from numpy.typing import NDArray

from . import _mesh_file as meshes

Array = NDArray[Any]

_KEYS = {
    "format", "name", "about", "step", "duration", "method", "particles", "forces", "contacts", "network", "constraints",
    "constraint_iterations", "substeps", "most_substeps", "fixed", "motions", "kinematic", "skins", "tethers", "wind", "origin",
    "faces", "push_out", "meet", "emitters", "capacity", "removal",
}  # fmt: skip
_COUPLING = {"scheme": "scheme", "substeps": "substeps", "most_substeps": "most_substeps", "theta": "theta", "sweep": "sweeps",
             "lines": "lines", "method": "method", "axis": "axis"}  # fmt: skip


def read_scene(cls: Type[Any], path: Union[str, "os.PathLike[str]"]) -> Any:
    """A Scene of class `cls`."""
    file = pathlib.Path(path)
    try:
        root = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as fault:
        raise ValueError(f"{path}: {fault}") from None
    try:
        return _Reader(root, file.parent).scene(cls)
    except KeyError as missing:
        raise ValueError(f"{path}: {missing.args[0]} is missing") from None
    except ValueError as fault:
        raise ValueError(f"{path}: {fault}") from fault


class _Made(NamedTuple):
    """Particles that a network makes."""

    network: Dict[str, Any]
    places: Array  # (n, 3), m
    of: Array  # the particle, from its first on, of each number by which the file names them; -1: it is left out
    mass: float  # kg, of each
    columns: int  # of a grid; else 0
    mesh: Optional[meshes.Mesh]
    first: int  # particle of the scene
    first_number: int


class _Reader:
    def __init__(self, root: Any, folder: pathlib.Path) -> None:
        if not isinstance(root, dict) or root.get("format") != "dvdx-scene/1":
            raise ValueError('format: must be "dvdx-scene/1"')
        for key in root.keys() - _KEYS:
            raise ValueError(f"{key}: is not read by Scene.load()")
        self.root, self.folder = root, folder
        self.capacity: Optional[int] = root.get("capacity")
        self.made: List[_Made] = []
        networks = root.get("network", [])
        self.networks: List[Dict[str, Any]] = networks if isinstance(networks, list) else [networks]
        self.motions: Dict[str, int] = {name: i for i, name in enumerate(root.get("motions", {}))}
        self.mass: Any = None
        self.positions, self.velocities = self.particles()

    # ---- particles

    def particles(self) -> Tuple[Array, Array]:
        own = self.root.get("particles", {})
        for network in self.networks:
            if "broken" in network:
                raise ValueError("network: what is torn is not read by Scene.load()")
            if network["type"] in ("grid", "mesh"):
                self.made.append(self.grid_made(network) if network["type"] == "grid" else self.mesh_made(network))
        if not self.made:
            count = own.get("count", 0) if "emitters" in self.root else own["count"]
            self.particle_of = np.arange(count)  # of each number by which the file names particles; -1: there is none
            self.numbers = self.particle_of  # of each particle
            self.mass = self.scalars(own["mass"], count) if "mass" in own else None
            positions = self.vectors(own.get("position", [0, 0, 0]), count)
            return positions, self.vectors(own.get("velocity", [0, 0, 0]), count)
        self.particle_of = np.concatenate([np.where(each.of < 0, -1, each.first + each.of) for each in self.made])
        named, first = np.unique(self.particle_of, return_index=True)
        self.numbers = first[named >= 0]
        alike = all(each.mass == self.made[0].mass for each in self.made)
        masses = np.concatenate([np.full(len(each.places), each.mass) for each in self.made])
        self.mass = self.made[0].mass if alike else masses
        positions = np.concatenate([each.places for each in self.made])
        velocities = self.vectors(own.get("velocity", [0, 0, 0]), len(self.particle_of))
        return positions, velocities[self.numbers]

    def next_made(self) -> Tuple[int, int]:
        """The first particle, and the first number, of what is made next."""
        return sum(len(each.places) for each in self.made), sum(len(each.of) for each in self.made)

    def grid_made(self, grid: Dict[str, Any]) -> _Made:
        rows, columns = grid["rows"], grid["columns"]
        if min(rows, columns) < 2:
            raise ValueError("network: a grid of one row or one column is not read by Scene.load()")
        origin, edge_u, edge_v = (np.array(grid[key], float) for key in ("origin", "edge_u", "edge_v"))
        u = (np.arange(columns) / (columns - 1))[None, :, None]
        v = (np.arange(rows) / (rows - 1))[:, None, None]
        places: Array = (origin + u * edge_u + v * edge_v).reshape(-1, 3)
        return _Made(grid, places, np.arange(len(places)), grid["mass"] / len(places), columns, None, *self.next_made())

    def mesh_made(self, network: Dict[str, Any]) -> _Made:
        file = meshes.read_mesh(self.folder / network["file"])
        mesh, of = meshes.welded(file, network.get("weld", 0), network.get("unreferenced") == "keep")
        count = len(mesh.vertices)
        return _Made(network, mesh.vertices, of, network["mass"] / count, 0, mesh, *self.next_made())

    def vectors(self, value: Any, count: int) -> Array:
        if isinstance(value, list):
            return np.tile(np.array(value, float), (count, 1))
        if "uniform" in value:
            least, most, seed = (value["uniform"][key] for key in ("min", "max", "seed"))
            columns = [_drawn(least[axis], most[axis], seed, count, axis) for axis in range(3)]
            return np.stack(columns, axis=1)
        if "lattice" in value:
            return _lattice(value["lattice"], count)
        return self.listed(value, (count, 3))

    def scalars(self, value: Any, count: int) -> Any:
        if not isinstance(value, dict):
            return value
        if "uniform" in value:
            return _drawn(value["uniform"]["min"], value["uniform"]["max"], value["uniform"]["seed"], count, 0)
        return self.listed(value, (count,))

    def listed(self, value: Dict[str, Any], shape: Tuple[int, ...]) -> Array:
        if "values" in value:
            numbers = np.array(value["values"], float)
        elif value["file"].endswith(".npy"):
            numbers = np.load(self.folder / value["file"], allow_pickle=False).astype(float)
        else:
            raise ValueError(f"{value['file']}: must end in .npy for Scene.load()")
        if numbers.size != np.prod(shape):
            raise ValueError(f"{numbers.shape} numbers: must be {shape}")
        return numbers.reshape(shape)

    def ids(self, value: Any) -> Array:
        """Numbers of particles; words name the top of the first grid."""
        listed: List[int] = []
        for each in [value] if isinstance(value, str) else value:
            if each == "all":
                listed += range(len(self.particle_of))
            elif isinstance(each, str):
                listed += self.top(each, 0)
            else:
                listed.append(each)
        particles = self.particle_of[np.array(listed, np.int64)]
        kept: Array = particles[particles >= 0]
        return kept

    def pairs(self, value: Any) -> Array:
        particles: Array = self.particle_of[np.array(value, np.int64).reshape(-1, 2)]
        return particles

    def top(self, word: str, grid: int) -> List[int]:
        grids = [each for each in self.made if each.columns]
        if word not in ("corners_top", "edge_top") or grid >= len(grids):
            raise ValueError(f"{word!r}: must be numbers of particles, or corners_top or edge_top of a grid")
        first, columns = grids[grid].first_number, grids[grid].columns
        return [first, first + columns - 1] if word == "corners_top" else list(range(first, first + columns))

    # ---- the scene

    def scene(self, cls: Type[Any]) -> Any:
        root = self.root
        origin = root.get("origin", "auto")
        scene = cls(method=root.get("method"), mass=self.mass, fixed=self.fixed(), origin=None if origin == "auto" else origin)
        scene.step, scene.duration = root["step"], root["duration"]
        self.velocities[self.fixed()] = 0  # as in a run
        scene._start = self.positions, self.velocities
        made = iter(self.made)
        for network in self.networks:
            index = sum(kind in ("grid", "springs") for kind, _ in scene._items)
            self.add_network(scene, index, network, next(made) if network["type"] in ("grid", "mesh") else None)
            if "tears_at" in network:
                scene.tears_at = {**scene.tears_at, index: network["tears_at"]}
        for motion in root.get("motions", {}).values():
            still = {"translation": (0, 0, 0), "rotation": (0, 0, 0)}
            keys = [still | key for key in motion["keys"]]
            rows = [[key["time"], *key["translation"], *key["rotation"]] for key in keys]
            scene.motion(keys=rows, center=motion.get("center", (0, 0, 0)))
            for k, key in enumerate(motion["keys"]):
                if key.get("jump"):
                    scene.jump(self.motions_made(scene) - 1, k)
        for force in root.get("forces", []):
            given = {key: self.force_value(key, value) for key, value in _rest(force)}
            getattr(scene, _type(force, "forces", FORCES))(**given)
        for i, contact in enumerate(root.get("contacts", [])):
            self.add_contact(scene, i, contact)
        for constraint in root.get("constraints", []):
            self.add_constraint(scene, constraint)
        self.add_coupling(scene)
        for group in root.get("kinematic", []):
            scene.kinematic(particles=self.ids(group["particles"]), motion=self.motion(group["motion"]))
        for i, skin in enumerate(root.get("skins", [])):
            self.add_skin(scene, i, skin)
        for tethers in root.get("tethers", []):
            scene.tethers(**tethers)
        if "wind" in root:
            self.add_wind(scene, root["wind"])
        if "meet" in root:
            self.add_meet(scene, root["meet"])
        if "faces" in root:
            scene.faces({"auto": "automatic"}.get(root["faces"], root["faces"]))
        if self.capacity is not None:
            scene.turnover = self.turnover()
        return scene

    @staticmethod
    def motions_made(scene: Any) -> int:
        return sum(kind == "motion" for kind, _ in scene._items)

    def motion(self, name: str) -> int:
        if name not in self.motions:
            raise ValueError(f"motion {name!r}: must be one of {', '.join(self.motions)}")
        return self.motions[name]

    def fixed(self) -> List[int]:
        named: List[int] = []
        grid = 0
        for network in self.networks:
            given = network.get("fixed", [])
            for each in [given] if isinstance(given, str) else given:
                named += self.top(each, grid) if isinstance(each, str) else [each]
            grid += network["type"] == "grid"
        return sorted({*self.ids(self.root.get("fixed", [])).tolist(), *self.ids(named).tolist()})

    def add_network(self, scene: Any, index: int, network: Dict[str, Any], made: Optional[_Made]) -> None:
        damping = network.get("damping", 0)
        if made is not None and made.mesh is not None:
            self.add_mesh(scene, index, network, made, made.mesh)
        elif made is not None:
            keys = ("rows", "columns", "edge_u", "edge_v", "structural", "shear", "bend")
            given = {key: network[key] for key in keys if key in network}
            scene.grid(first=made.first, damping=damping, **given)
            if "aerodynamics" in network:
                scene.aerodynamics(network=index, **network["aerodynamics"])
            if "strain_limit" in network:
                self.add_grid_limit(scene, network, made)
        elif network["type"] == "springs":
            pairs = self.pairs(network["pairs"])
            rest = network["rest_length"]
            rest = rest if rest == "start" else self.scalars(rest, len(pairs))
            stiffness = self.scalars(network["stiffness"], len(pairs))
            scene.springs(pairs=pairs, stiffness=stiffness, rest_length=rest, damping=damping)
        else:
            raise ValueError(f"network: {network['type']!r}: must be grid, mesh or springs")

    @staticmethod
    def add_mesh(scene: Any, index: int, network: Dict[str, Any], made: _Made, mesh: meshes.Mesh) -> None:
        edge, bend = network.get("edge", 0), network.get("bend", 0)
        lists = ((meshes.edges(mesh), edge), (meshes.diagonals(mesh), edge), (meshes.bends(mesh), bend))
        pairs = [pair for some, stiffness in lists if stiffness for pair in some]
        stiffness = [stiffness for some, stiffness in lists if stiffness for _ in some]
        if not pairs and not network.keys() & {"aerodynamics", "bending"}:
            return
        if not pairs:
            raise ValueError("network: a mesh without edge and bend is not read by Scene.load()")
        scene.springs(pairs=made.first + np.array(pairs), stiffness=stiffness, damping=network.get("damping", 0))
        triangles = made.first + meshes.triangles(mesh)
        if network.get("bending", 0):
            flat = np.concatenate([np.zeros((made.first, 3)), made.places])
            scene.bending(network=index, modulus=network["bending"], triangles=triangles, flat=flat)
        if len(triangles):
            air = network.get("aerodynamics", {"density": 0})
            scene.aerodynamics(network=index, triangles=triangles, **air)
        if "strain_limit" in network:
            sides = meshes.edges(mesh)
            lengths = [(1 + network["strain_limit"]) * meshes.length(made.places[b] - made.places[a]) for a, b in sides]
            scene.distance(pairs=made.first + np.array(sides), length=lengths, bound="at_most")

    @staticmethod
    def add_grid_limit(scene: Any, grid: Dict[str, Any], made: _Made) -> None:
        at = made.first + np.arange(len(made.places)).reshape(grid["rows"], grid["columns"])
        along = np.stack([at[:, :-1], at[:, 1:]], axis=-1).reshape(-1, 2)
        down = np.stack([at[:-1], at[1:]], axis=-1).reshape(-1, 2)
        sides = (meshes.length(grid["edge_u"]) / (grid["columns"] - 1), meshes.length(grid["edge_v"]) / (grid["rows"] - 1))
        lengths = [(1 + grid["strain_limit"]) * side for some, side in zip((along, down), sides) for _ in some]
        scene.distance(pairs=np.concatenate([along, down]), length=lengths, bound="at_most")

    # ---- particles that come and go

    def turnover(self) -> Dict[str, Any]:
        removal = self.root.get("removal", {})
        found: Dict[str, Any] = {
            "emitters": [self.emitter(each) for each in self.root.get("emitters", [])],
            "boundaries": removal.get("boundaries", []),
            "not_finite": removal.get("not_finite", "kept"),
            "order": removal.get("order", "kept"),
            "capacity": self.capacity,
        }
        if "outside" in removal:
            found["inside"] = (removal["outside"]["min"], removal["outside"]["max"])
        return found

    def emitter(self, given: Dict[str, Any]) -> Dict[str, Any]:
        kind = _type(given, "emitters", ("point", "disc", "box"))
        keys = ("at", "normal", "radius", "rate", "start", "velocity", "seed")
        found = {"shape": kind} | {key: given[key] for key in keys if key in given}
        if kind == "disc":
            found["at"] = given["center"]
        if kind == "box":
            found |= {"at": given["min"], "most": given["max"]}
        spread = given.get("spread", 0)
        found["spread_box" if isinstance(spread, list) else "spread"] = spread
        lifetime = given.get("lifetime")
        if lifetime is not None:
            ends = (lifetime["min"], lifetime["max"]) if isinstance(lifetime, dict) else (lifetime, lifetime)
            found |= {"least_lifetime": ends[0], "most_lifetime": ends[1]}
        if "end" in given:
            duration = given["end"] - given.get("start", 0)
            found |= {"duration": duration} if duration > 0 else {"rate": 0}
        if "motion" in given:
            found["motion"] = self.motion(given["motion"])
        return found

    def add_coupling(self, scene: Any) -> None:
        root = self.root
        given = self.networks[0] if self.networks else {key: root[key] for key in ("substeps", "most_substeps") if key in root}
        coupling = {name: given[key] for key, name in _COUPLING.items() if given.get(key, "auto") != "auto"}
        if given.get("scheme") == "auto":
            coupling["scheme"] = "automatic"
        if "method" in root and self.networks:
            coupling.setdefault("method", root["method"])
        if "constraint_iterations" in root:
            coupling["iterations"] = root["constraint_iterations"]
        if coupling:
            scene.coupling(**coupling)

    def force_value(self, key: str, value: Any) -> Any:
        if key in ("stiffness", "coefficient") and isinstance(value, list):
            return tuple(value)  # one an axis
        if not isinstance(value, dict):
            return value
        count = len(self.particle_of)
        return self.vectors(value, count)[self.numbers] if key == "anchor" else self.scalars_each(value)

    def scalars_each(self, value: Any) -> Any:
        """One number, or one for each particle, which the file gives by its own numbers."""
        given = self.scalars(value, len(self.particle_of))
        return given[self.numbers] if isinstance(given, np.ndarray) else given

    def add_contact(self, scene: Any, index: int, contact: Dict[str, Any]) -> None:
        kind = _type(contact, "contacts", ("plane", "sphere", "capsule", "box", "convex", "mesh"))
        given = {key: value for key, value in _rest(contact) if key != "motion"}
        if kind in ("capsule", "convex", "mesh"):
            given.pop("side", None)
        if kind == "mesh":
            mesh = meshes.read_mesh(self.folder / given.pop("file"))
            given |= {"vertices": mesh.vertices, "triangles": meshes.triangles(mesh)}
        if kind == "convex":
            given["planes"] = [[*plane["normal"], plane["offset"]] for plane in given["planes"]]
        if "push_out" in self.root:
            given.setdefault("push_out", self.root["push_out"])
        getattr(scene, kind)(**given)
        if "motion" in contact:
            scene.contact_motion(index, self.motion(contact["motion"]))

    def add_constraint(self, scene: Any, constraint: Dict[str, Any]) -> None:
        kind = _type(constraint, "constraints", ("distance", "point", "line"))
        given = dict(_rest(constraint))
        if kind == "distance":
            given["pairs"] = self.pairs(given["pairs"])
            length = given["length"]
            given["length"] = length if length == "start" else self.scalars(length, len(given["pairs"]))
        else:
            given["particle"] = int(self.ids([given["particle"]])[0])
        getattr(scene, {"distance": "distance", "point": "on_point", "line": "on_line"}[kind])(**given)

    def add_skin(self, scene: Any, index: int, skin: Dict[str, Any]) -> None:
        scene.skin(particles=self.ids(skin["particles"]), points=skin.get("points"), at_most=skin.get("at_most"))
        if "backstop" in skin:
            backstop = dict(skin["backstop"])
            backstop["normals"] = np.atleast_2d(backstop["normals"])
            scene.backstop(skin=index, **backstop)
        if "motion" in skin:
            scene.skin_motion(index, self.motion(skin["motion"]))

    def add_meet(self, scene: Any, meet: Dict[str, Any]) -> None:
        given = {key: value for key, value in meet.items() if key not in ("radius", "apart_at_start", "groups")}
        if "radius" in meet:
            given["radius"] = self.scalars_each(meet["radius"])
        if "apart_at_start" in meet:
            given["near_at_start"] = "pass" if meet["apart_at_start"] else "meet"
        scene.meet(**given)
        if "groups" in meet:
            scene.meet_groups(**meet["groups"])

    @staticmethod
    def add_wind(scene: Any, wind: Any) -> None:
        if isinstance(wind, list):
            scene.wind(mean=wind)
            return
        rows = [[*gust["amplitude"], gust["angular_frequency"], gust.get("phase", 0)] for gust in wind.get("gusts", [])]
        scene.wind(mean=wind.get("mean", (0, 0, 0)), gusts=np.reshape(np.array(rows, float), (-1, 5)))


FORCES = ("constant", "polynomial", "sinusoid", "spring", "radial_spring", "drag")


def _type(item: Dict[str, Any], name: str, kinds: Tuple[str, ...]) -> str:
    kind: Optional[str] = item.get("type")
    if kind not in kinds:
        raise ValueError(f"{name}: type {kind!r} must be one of {', '.join(kinds)} for Scene.load()")
    return kind


def _rest(item: Dict[str, Any]) -> List[Tuple[str, Any]]:
    return [(key, value) for key, value in item.items() if key != "type"]


def _lattice(given: Dict[str, Any], count: int) -> Array:
    """Points of a cubic lattice, along x first, then z, then y, each drawn from around its own: docs/scene.md."""
    least, most, spacing = (np.array(given[key], float) for key in ("min", "max", "spacing"))
    x, _, z = (1 + ((most - least) / spacing * (1 + 1e-12)).astype(int)).tolist()
    i = np.arange(count)
    places: Array = least + spacing * np.stack([i % x, i // x // z, i // x % z], axis=1)
    jitter = given.get("jitter", 0)
    if jitter > 0:
        places += np.stack([_drawn(-jitter, jitter, given["seed"], count, axis) for axis in range(3)], axis=1)
    return places


def _drawn(least: float, most: float, seed: int, count: int, axis: int) -> Array:
    """least + (most - least) u, u by Philox4x32-10 of (particle, axis) under the seed: docs/scene.md."""
    mask = np.uint64(0xFFFFFFFF)
    particle = np.arange(count, dtype=np.uint64)
    words = [particle & mask, particle >> np.uint64(32), np.full(count, axis, np.uint64), np.zeros(count, np.uint64)]
    keys = [seed & 0xFFFFFFFF, seed >> 32]
    for _ in range(10):
        first, second = words[0] * np.uint64(0xD2511F53), words[2] * np.uint64(0xCD9E8D57)
        words = [
            (second >> np.uint64(32)) ^ words[1] ^ np.uint64(keys[0]), second & mask,
            (first >> np.uint64(32)) ^ words[3] ^ np.uint64(keys[1]), first & mask,
        ]  # fmt: skip
        keys = [(keys[0] + 0x9E3779B9) & 0xFFFFFFFF, (keys[1] + 0xBB67AE85) & 0xFFFFFFFF]
    unit = ((words[0] | words[1] << np.uint64(32)) >> np.uint64(11)).astype(float) * 2.0**-53
    value: Array = least + (most - least) * unit
    return np.where((value < most) | (least == most), value, np.nextafter(most, least))
