"""Scene files (dvdx-scene/1) as scenes: what Scene.load() reads. The command's own reader says more of a file that is wrong."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Dict, List, Optional, Tuple, Type, Union

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

_KEYS = {
    "format", "name", "about", "step", "duration", "method", "particles", "forces", "contacts", "network", "constraints",
    "constraint_iterations", "substeps", "most_substeps", "fixed", "motions", "kinematic", "skins", "tethers", "wind", "origin",
    "faces", "push_out", "meet",
}  # fmt: skip
_COUPLING = {"scheme": "scheme", "substeps": "substeps", "most_substeps": "most_substeps", "theta": "theta", "sweep": "sweeps",
             "lines": "lines", "method": "method", "axis": "axis"}  # fmt: skip
_NOT_READ = {"mesh": "a mesh", "strain_limit": "a strain limit", "tears_at": "what tears", "broken": "what is torn"}


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


class _Reader:
    def __init__(self, root: Any, folder: pathlib.Path) -> None:
        if not isinstance(root, dict) or root.get("format") != "dvdx-scene/1":
            raise ValueError('format: must be "dvdx-scene/1"')
        for key in root.keys() - _KEYS:
            raise ValueError(f"{key}: is not read by Scene.load()")
        if root.get("faces", "auto") != "auto":
            raise ValueError("faces: is not read by Scene.load() but as auto")
        self.root, self.folder = root, folder
        networks = root.get("network", [])
        self.networks: List[Dict[str, Any]] = networks if isinstance(networks, list) else [networks]
        self.motions: Dict[str, int] = {name: i for i, name in enumerate(root.get("motions", {}))}
        self.grids: List[Tuple[int, int]] = []  # of each the first particle, and columns
        self.mass: Any = None
        self.positions, self.velocities = self.particles()

    # ---- particles

    def particles(self) -> Tuple[Array, Array]:
        own = self.root.get("particles", {})
        made = [self.grid_particles(each) for each in self.networks if each["type"] == "grid"]
        for network in self.networks:
            self.refuse(network)
        if made:
            positions = np.concatenate(made)
            masses = [(each["mass"] / len(some), len(some)) for each, some in zip(self.only_grids(), made)]
            alike = all(mass == masses[0][0] for mass, _ in masses)
            self.mass = masses[0][0] if alike else np.concatenate([np.full(count, mass) for mass, count in masses])
        else:
            count = own["count"]
            positions = self.vectors(own.get("position", [0, 0, 0]), count)
            self.mass = self.scalars(own["mass"], count) if "mass" in own else None
        return positions, self.vectors(own.get("velocity", [0, 0, 0]), len(positions))

    def only_grids(self) -> List[Dict[str, Any]]:
        return [each for each in self.networks if each["type"] == "grid"]

    def refuse(self, network: Dict[str, Any]) -> None:
        for key, words in _NOT_READ.items():
            if key in network or network["type"] == key:
                raise ValueError(f"network: {words} is not read by Scene.load()")

    def grid_particles(self, grid: Dict[str, Any]) -> Array:
        rows, columns = grid["rows"], grid["columns"]
        if min(rows, columns) < 2:
            raise ValueError("network: a grid of one row or one column is not read by Scene.load()")
        origin, edge_u, edge_v = (np.array(grid[key], float) for key in ("origin", "edge_u", "edge_v"))
        self.grids.append((sum(each["rows"] * each["columns"] for each in self.only_grids()[: len(self.grids)]), columns))
        u = (np.arange(columns) / (columns - 1))[None, :, None]
        v = (np.arange(rows) / (rows - 1))[:, None, None]
        places: Array = (origin + u * edge_u + v * edge_v).reshape(-1, 3)
        return places

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
                listed += range(len(self.positions))
            elif isinstance(each, str):
                listed += self.top(each, 0)
            else:
                listed.append(each)
        return np.array(listed, np.int64)

    def top(self, word: str, grid: int) -> List[int]:
        if word not in ("corners_top", "edge_top") or grid >= len(self.grids):
            raise ValueError(f"{word!r}: must be numbers of particles, or corners_top or edge_top of a grid")
        first, columns = self.grids[grid]
        return [first, first + columns - 1] if word == "corners_top" else list(range(first, first + columns))

    # ---- the scene

    def scene(self, cls: Type[Any]) -> Any:
        root = self.root
        origin = root.get("origin", "auto")
        scene = cls(method=root.get("method"), mass=self.mass, fixed=self.fixed(), origin=None if origin == "auto" else origin)
        scene.step, scene.duration = root["step"], root["duration"]
        scene._start = self.positions, self.velocities
        for network in self.networks:
            self.add_network(scene, network)
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
            getattr(scene, _type(force, "forces", _FORCES))(**given)
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
        return scene

    @staticmethod
    def motions_made(scene: Any) -> int:
        return sum(kind == "motion" for kind, _ in scene._items)

    def motion(self, name: str) -> int:
        if name not in self.motions:
            raise ValueError(f"motion {name!r}: must be one of {', '.join(self.motions)}")
        return self.motions[name]

    def fixed(self) -> List[int]:
        ids = self.ids(self.root.get("fixed", [])).tolist()
        grid = 0
        for network in self.networks:
            given = network.get("fixed", [])
            for each in [given] if isinstance(given, str) else given:
                ids += self.top(each, grid) if isinstance(each, str) else [each]
            grid += network["type"] == "grid"
        return sorted(set(ids))

    def add_network(self, scene: Any, network: Dict[str, Any]) -> None:
        damping = network.get("damping", 0)
        index = sum(kind in ("grid", "springs") for kind, _ in scene._items)
        if network["type"] == "grid":
            keys = ("rows", "columns", "edge_u", "edge_v", "structural", "shear", "bend")
            given = {key: network[key] for key in keys if key in network}
            scene.grid(first=self.grids[sum(kind == "grid" for kind, _ in scene._items)][0], damping=damping, **given)
            if "aerodynamics" in network:
                scene.aerodynamics(network=index, **network["aerodynamics"])
        elif network["type"] == "springs":
            pairs = np.array(network["pairs"]).reshape(-1, 2)
            rest = network["rest_length"]
            rest = rest if rest == "start" else self.scalars(rest, len(pairs))
            stiffness = self.scalars(network["stiffness"], len(pairs))
            scene.springs(pairs=pairs, stiffness=stiffness, rest_length=rest, damping=damping)
        else:
            raise ValueError(f"network: {network['type']!r}: must be grid or springs")

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
        return self.vectors(value, len(self.positions)) if key == "anchor" else self.scalars(value, len(self.positions))

    def add_contact(self, scene: Any, index: int, contact: Dict[str, Any]) -> None:
        kind = _type(contact, "contacts", ("plane", "sphere", "capsule", "box", "convex"))
        given = {key: value for key, value in _rest(contact) if key != "motion"}
        if kind in ("capsule", "convex"):
            given.pop("side", None)
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
            given["pairs"] = np.array(given["pairs"]).reshape(-1, 2)
            length = given["length"]
            given["length"] = length if length == "start" else self.scalars(length, len(given["pairs"]))
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
            given["radius"] = self.scalars(meet["radius"], len(self.positions))
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


_FORCES = ("constant", "polynomial", "sinusoid", "spring", "radial_spring", "drag")


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
