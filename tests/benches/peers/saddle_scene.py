"""Scene files (TOML) as problems: body, surface, supports, loads, and where all of them are at each increment."""
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import saddle_area
import saddle_axis
import saddle_law
import saddle_mesh
import saddle_obstacle
from saddle_bend import Bent
from saddle_body import Body
from saddle_rule import p2, rule
from saddle_surface import Surface

AXES = "xyz"
# From this Poisson ratio on, a pressure carries the volume.
MIXED_FROM = 0.45
# Rule of the volume where the scene names none: exact for linear bodies.
DEGREE = 2


@dataclass
class Drive:
    """Held values [held dofs], poses (translation, rotation) of the obstacles, factor of the loads."""

    values: np.ndarray
    poses: list
    load: float

    def between(self, other, t):
        """The drive a fraction `t` of the way to `other`."""
        poses = [tuple((1 - t) * a + t * b for a, b in zip(p, q)) for p, q in zip(self.poses, other.poses)]
        return Drive((1 - t) * self.values + t * other.values, poses, (1 - t) * self.load + t * other.load)


class Problem:
    """A scene with its mesh; `space` and what `changes` names (mesh, degree) override the scene's."""

    def __init__(self, path, space=None, changes=None):
        path = Path(path)
        with open(path, "rb") as file:
            self.scene = tomllib.load(file)
        scene = self.scene
        refuse(scene)
        changes = changes or {}
        mesh = changes.get("mesh") or path.parent / scene["mesh"]
        self.mesh = saddle_mesh.read(mesh, scene.get("mesh_scale", 1.0))
        solver = scene.get("solver", {})
        materials = scene["material"]
        self.laws = saddle_law.of_all(materials)
        self.is_rubber = any(law.is_rubber for law in self.laws.values())
        mixed = any(is_mixed(table) for table in materials.values())
        if not mixed:
            for law in self.laws.values():
                law.lame, law.inverse_bulk = 1.0 / law.inverse_bulk, 0.0
        is_revolved = scene.get("kind") == "axisymmetric"
        degree = changes.get("degree") or solver.get("quadrature_degree")
        degree = degree or (saddle_axis.DEGREE if is_revolved else DEGREE)
        kind = saddle_axis.Revolved if is_revolved else Bent if self.mesh.middles else Body
        self.body = kind(self.mesh, self.laws, degree, mixed)
        self.supports = scene.get("support", [])
        self.held, self.owner = self.hold()
        self.obstacles = [saddle_obstacle.of(o["shape"]) for o in scene.get("obstacle", [])]
        self.obstacle_names = [o["name"] for o in scene.get("obstacle", [])]
        facets = [self.mesh.facets_of(listed(o["on"])) for o in scene.get("obstacle", [])]
        is_held = np.zeros(self.body.displacements, dtype=bool)
        is_held[self.held] = True
        space = space or solver.get("contact_space", "quadratic")
        measure = saddle_area.Deformed if self.is_rubber else saddle_area.Undeformed
        measure = saddle_axis.Ring if is_revolved else measure
        self.surface = Surface(self.mesh, facets, is_held, space, measure)
        self.load = self.dead_load()

    def hold(self):
        """Held dofs, and for each the (support, component) whose value it takes; the last support wins."""
        owner = {}
        for number, support in enumerate(self.supports):
            facets = self.mesh.facets_of(listed(support["on"]))
            nodes = np.unique(self.mesh.facet_nodes(facets))
            if "normal" in support:
                support["displacement"] = {AXES[plane_axis(self.mesh.points[facets])]: 0.0}
            for axis in support.get("displacement", {}):
                component = AXES.index(axis)
                if component < self.mesh.dim:
                    owner.update({self.mesh.dim * node + component: (number, axis) for node in nodes.tolist()})
        held = np.array(sorted(owner), dtype=int)
        return held, [owner[dof] for dof in held.tolist()]

    def dead_load(self):
        """Forces of tractions and body forces at load factor one."""
        load = np.zeros(self.body.displacements)
        for traction in self.scene.get("traction", []):
            facets = self.mesh.facets_of(listed(traction["on"]))
            self.add_load(load, facets, self.mesh.facet_nodes(facets), traction["value"])
        if "body_force" in self.scene:
            self.add_load(load, self.mesh.cells, self.mesh.cell_nodes, self.scene["body_force"]["value"])
        return load

    def add_load(self, load, simplices, nodes, value):
        points, weights = rule(simplices.shape[1], 4)
        shares = np.outer(measures(self.mesh.points[simplices]), weights @ p2(points))
        value = np.array(value)[: self.mesh.dim]
        np.add.at(load.reshape(-1, self.mesh.dim), nodes, shares[..., None] * value)

    def start(self):
        """The undeformed state: nothing moved, no load."""
        zero = (np.zeros(3), np.zeros(3))
        return Drive(np.zeros(len(self.held)), [zero for _ in self.obstacles], 0.0)

    def steps(self):
        """(increments, drive at the end) of each step."""
        values = {(i, axis): value for i, s in enumerate(self.supports) for axis, value in s["displacement"].items()}
        names = [support.get("name") for support in self.supports]
        poses = self.start().poses
        load = 1.0
        for step in self.scene.get("step", [{}]):
            load = step.get("load", load)
            for name, target in step.get("support", {}).items():
                for axis, value in target["displacement"].items():
                    values[names.index(name), axis] = value
            for name, target in step.get("obstacle", {}).items():
                number = self.obstacle_names.index(name)
                old = poses[number]
                pose = (target.get("translation", old[0]), target.get("rotation", old[1]))
                poses = poses[:number] + [tuple(np.array(p, dtype=float) for p in pose)] + poses[number + 1 :]
            held = np.array([values[key] for key in self.owner])
            yield step.get("increments", 1), Drive(held, poses, load)

    def placed(self, drive):
        return [o.moved(*pose) for o, pose in zip(self.obstacles, drive.poses)]


def measures(corners):
    """Length, area or volume of simplices [n, corners, dim]."""
    sides = corners[:, 1:] - corners[:, :1]
    gram = np.einsum("nai,nbi->nab", sides, sides)
    return np.sqrt(np.linalg.det(gram)) / (1.0, 1.0, 2.0, 6.0)[sides.shape[1]]


def plane_axis(corners):
    """The axis along which facets [n, corners, dim] of one plane have no extent."""
    spread = np.ptp(corners.reshape(-1, corners.shape[2]), axis=0)
    axis = int(np.argmin(spread))
    if spread[axis] > 1e-9 * spread.max():
        raise ValueError("supports along normals of other planes than those of the axes are not solved here")
    return axis


def listed(names):
    return [names] if isinstance(names, str) else names


def is_mixed(table):
    return table["model"] != "linear-elastic" or table["poisson_ratio"] >= MIXED_FROM


def refuse(scene):
    """What this code does not solve."""
    for key in ("pressure", "manufactured"):
        if key in scene:
            raise ValueError(f"`{key}` is not solved here")
    if scene.get("kind") == "axisymmetric" and ("traction" in scene or "body_force" in scene):
        raise ValueError("loads on bodies of revolution are not solved here")
    if any(support.get("normal") for support in scene.get("support", [])):
        raise ValueError("moved supports along a normal are not solved here")
