"""Scenes as keyword classes, with the keys of scene files.

`Scene(...)` is the same as the dictionary of a scene file, and may hold dictionaries in the place
of any class. What the keys mean is in the manual of scenes; the program of the package reads them,
so that a scene means the same here and on the command line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ._values import Values
from .mesh import Mesh

Vector = Sequence[float] | npt.NDArray[Any]
Names = str | Sequence[str]
Components = Mapping[str, float]
#: Values by node, facet or cell: an array of rows, `Values`, or in a scene the name of a file.
Given = Values | npt.NDArray[Any] | str | Path

#: Key of scene files for a field of these classes that has another name.
KEYS = {"materials": "material", "supports": "support", "tractions": "traction", "pressures": "pressure"}
KEYS |= {"obstacles": "obstacle", "steps": "step", "probes": "probe", "fluids": "fluid", "gradients": "gradient"}
KEYS |= {"itself": "self"}
KEYS |= {"contacts": "contact", "ties": "tie", "bodies": "body"}


class Part:
    """A table of a scene file."""

    #: Keys with a fixed value.
    constant: ClassVar[dict[str, str]] = {}

    def as_dict(self) -> dict[str, Any]:
        """The table; what is None is left out."""
        given = {KEYS.get(one.name, one.name): getattr(self, one.name) for one in fields(self)}  # type: ignore[arg-type]
        there = {key: value for key, value in given.items() if not empty(value)}
        return {**self.constant, **plain(there)}


def empty(value: Any) -> bool:
    """Whether a key is left out."""
    return value is None or (isinstance(value, (list, tuple, dict)) and len(value) == 0)


def is_rows(key: str, value: Any) -> bool:
    """Whether these are values by node, which no text holds."""
    return key == "values" and not isinstance(value, (str, Path))


def plain(value: Any) -> Any:
    """Values as TOML knows them: classes as tables, arrays as lists."""
    if isinstance(value, Part):
        return value.as_dict()
    if isinstance(value, Mapping):
        # Values stay arrays: no text has a place for them.
        tables = value.items()
        return {str(key): one if is_rows(key, one) else plain(one) for key, one in tables if one is not None}
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return str(value) if isinstance(value, Path) else value


@dataclass(kw_only=True)
class LinearElastic(Part):
    """Small strains; one modulus, and Poisson's ratio up to and including 0.5."""

    constant = {"model": "linear-elastic"}
    poisson_ratio: float
    shear_modulus: float | None = None
    young_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class Stokes(Part):
    """Viscous flow; displacements are velocities."""

    constant = {"model": "stokes"}
    viscosity: float
    formulation: str | None = None


@dataclass(kw_only=True)
class MooneyRivlin(Part):
    """Rubber with two constants; its shear modulus is 2 (c10 + c01)."""

    constant = {"model": "mooney-rivlin"}
    c10: float
    c01: float
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class NeoHookean(Part):
    """Rubber with one constant."""

    constant = {"model": "neo-hookean"}
    shear_modulus: float
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class Yeoh(Part):
    """Rubber that stiffens: a cubic polynomial of the first invariant."""

    constant = {"model": "yeoh"}
    c10: float
    c20: float
    c30: float
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class Ogden(Part):
    """Rubber of one to three terms in the principal stretches."""

    constant = {"model": "ogden"}
    mu: Vector
    alpha: Vector
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class Polynomial(Part):
    """Rubber by Rivlin's polynomial up to the third order; its shear modulus is 2 (c10 + c01)."""

    constant = {"model": "polynomial"}
    c10: float = 0.0
    c01: float = 0.0
    c20: float = 0.0
    c11: float = 0.0
    c02: float = 0.0
    c30: float = 0.0
    c21: float = 0.0
    c12: float = 0.0
    c03: float = 0.0
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class Gent(Part):
    """Rubber of limited chain extensibility; `limit` is J_m, the limit of i1 - 3."""

    constant = {"model": "gent"}
    shear_modulus: float
    limit: float
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class ArrudaBoyce(Part):
    """Rubber by five terms of the eight-chain model."""

    constant = {"model": "arruda-boyce"}
    mu: float
    locking_stretch: float
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class VanDerWaals(Part):
    """Rubber as a van der Waals network: locking stretch, interaction `a`, share `beta` of the second invariant."""

    constant = {"model": "van-der-waals"}
    shear_modulus: float
    locking_stretch: float
    a: float = 0.0
    beta: float = 0.0
    bulk_modulus: float | None = None
    formulation: str | None = None


@dataclass(kw_only=True)
class Hyperfoam(Part):
    """A compressible foam of one to six terms in the principal stretches; `nu` is one for all or one per term."""

    constant = {"model": "hyperfoam"}
    mu: Vector
    alpha: Vector
    nu: Vector
    formulation: str | None = None


@dataclass(kw_only=True)
class BlatzKo(Part):
    """A compressible foamed rubber of Poisson ratio 1/4 at rest."""

    constant = {"model": "blatz-ko"}
    shear_modulus: float
    formulation: str | None = None


Material = (
    LinearElastic
    | Stokes
    | MooneyRivlin
    | NeoHookean
    | Yeoh
    | Ogden
    | Polynomial
    | Gent
    | ArrudaBoyce
    | VanDerWaals
    | Hyperfoam
    | BlatzKo
    | Mapping[str, Any]
)


@dataclass(kw_only=True)
class HalfSpace(Part):
    """All behind a plane; `normal` points to the free side."""

    constant = {"kind": "half-space"}
    point: Vector
    normal: Vector
    inside: bool | None = None


@dataclass(kw_only=True)
class Sphere(Part):
    """A ball, or a cavity with `inside`."""

    constant = {"kind": "sphere"}
    centre: Vector
    radius: float
    inside: bool | None = None


@dataclass(kw_only=True)
class Cylinder(Part):
    """An infinite cylinder, or a bore with `inside`."""

    constant = {"kind": "cylinder"}
    point: Vector
    axis: Vector
    radius: float
    inside: bool | None = None


@dataclass(kw_only=True)
class CappedCylinder(Part):
    """A cylinder between two points."""

    constant = {"kind": "capped-cylinder"}
    start: Vector
    end: Vector
    radius: float
    rounding: float | None = None
    inside: bool | None = None

    def as_dict(self) -> dict[str, Any]:
        """The table; its keys `from` and `to` are no names in Python."""
        table = super().as_dict()
        ends = {"from": table.pop("start"), "to": table.pop("end")}
        return {**table, **ends}


@dataclass(kw_only=True)
class Box(Part):
    """A box along the axes; `half_sizes` include the rounding."""

    constant = {"kind": "box"}
    centre: Vector
    half_sizes: Vector
    rounding: float | None = None
    inside: bool | None = None


@dataclass(kw_only=True)
class Torus(Part):
    """A ring."""

    constant = {"kind": "torus"}
    centre: Vector
    axis: Vector
    radius: float
    tube_radius: float
    inside: bool | None = None


@dataclass(kw_only=True)
class Cone(Part):
    """An infinite cone; `axis` points into it, `angle` lies between axis and surface, radians."""

    constant = {"kind": "cone"}
    apex: Vector
    axis: Vector
    angle: float
    rounding: float | None = None
    inside: bool | None = None


@dataclass(kw_only=True)
class Surface(Part):
    """A closed surface from an STL file; smoothed but at edges of more than `feature_angle`, degrees.

    Corners nearer than `weld` of the diagonal (1e-6) are one vertex.
    """

    constant = {"kind": "surface"}
    file: str | Path
    scale: float | None = None
    facets: bool | None = None
    feature_angle: float | None = None
    weld: float | None = None
    inside: bool | None = None


@dataclass(kw_only=True)
class HeightField(Part):
    """All below heights over a grid of x and y, with `inside` all above; see `write_grid`."""

    constant = {"kind": "height-field"}
    file: str | Path
    inside: bool | None = None


@dataclass(kw_only=True)
class DistanceGrid(Part):
    """All where signed distances on a grid are negative; see `write_grid`."""

    constant = {"kind": "distance-grid"}
    file: str | Path
    inside: bool | None = None


Analytic = HalfSpace | Sphere | Cylinder | CappedCylinder | Box | Torus | Cone
Shape = Analytic | Surface | HeightField | DistanceGrid | Mapping[str, Any]


@dataclass(kw_only=True)
class Support(Part):
    """Holds the named components of the displacement, or that along the normal, on surfaces."""

    on: Names
    displacement: Components | None = None
    normal: float | None = None
    profile: str | None = None
    name: str | None = None
    values: Given | None = None
    force: Components | None = None
    moment: Components | None = None
    stiffness: Components | None = None
    rotational_stiffness: Components | None = None
    about: Vector | None = None


@dataclass(kw_only=True)
class Traction(Part):
    """A dead load per undeformed area."""

    on: Names
    value: Vector | None = None
    name: str | None = None
    values: Given | None = None


@dataclass(kw_only=True)
class BodyForce(Part):
    """A dead load per undeformed volume."""

    value: Vector | None = None
    values: Given | None = None


@dataclass(kw_only=True)
class Pressure(Part):
    """A pressure that follows the deformed surface; positive pushes on the body."""

    on: Names
    value: float


@dataclass(kw_only=True)
class Body(Part):
    """A body with a mesh file of its own: scaled, turned about the origin by a vector, then moved."""

    name: str
    mesh: str | Path
    translation: Vector | None = None
    rotation: Vector | None = None
    mesh_scale: float | None = None


@dataclass(kw_only=True)
class BodyContact(Part):
    """Two groups of facets that may touch and leave each other, or one that may touch `itself`."""

    name: str
    between: Names
    itself: bool | None = None
    carries: str | None = None
    friction: float | None = None
    tresca: float | None = None


@dataclass(kw_only=True)
class Tie(Part):
    """Two groups of facets of different bodies that are bonded; their meshes need not match."""

    name: str
    between: Sequence[str]
    carries: str | None = None


@dataclass(kw_only=True)
class Fluid(Part):
    """A fluid that creeps in from the wet surfaces `source` and must not reach those that are `dry`."""

    name: str
    on: Names
    source: Names
    dry: Names | None = None
    pressure: float | None = None
    threshold: float | str | None = None
    film: str | None = None
    blow_off_tolerance: float | None = None
    viscosity: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """The table; its key `from` is no name in Python."""
        table = super().as_dict()
        table["from"] = table.pop("source")
        return table


@dataclass(kw_only=True)
class Obstacle(Part):
    """A rigid tool that surfaces of the body may touch."""

    name: str
    on: Names
    shape: Shape
    friction: float | None = None
    tresca: float | None = None
    surface: str | None = None
    initial_penetration: str | None = None


@dataclass(kw_only=True)
class Move(Part):
    """Where an obstacle shall be at the end of a step, from its first pose; radians."""

    translation: Vector | None = None
    rotation: Vector | None = None
    force: Components | None = None
    moment: Components | None = None
    friction: float | None = None


@dataclass(kw_only=True)
class SupportMove(Part):
    """What a support shall prescribe at the end of a step; radians."""

    displacement: Components | None = None
    translation: Vector | None = None
    rotation: Vector | None = None
    about: Vector | None = None
    values: Given | None = None
    force: Components | None = None
    moment: Components | None = None


@dataclass(kw_only=True)
class TractionChange(Part):
    """New values of a traction."""

    values: Given


@dataclass(kw_only=True)
class FluidPressure(Part):
    """Where the pressure of a fluid leads: a number, or `"to blow-off"` and `up_to` which one at most."""

    pressure: float | str
    up_to: float | None = None


@dataclass(kw_only=True)
class Step(Part):
    """A load step: targets that are reached in equal increments, each with a result."""

    increments: int | None = None
    load: float | None = None
    obstacles: Mapping[str, Move | Mapping[str, Any]] = field(default_factory=dict)
    supports: Mapping[str, SupportMove | Mapping[str, Any]] = field(default_factory=dict)
    tractions: Mapping[str, TractionChange | Mapping[str, Any]] = field(default_factory=dict)
    body_force: Mapping[str, Any] | None = None
    fluids: Mapping[str, FluidPressure | Mapping[str, Any] | float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The table; the pressure of a fluid alone is one of its own."""
        table = super().as_dict()
        fluids = table.get("fluid", {})
        own = {name: one if isinstance(one, Mapping) else {"pressure": one} for name, one in fluids.items()}
        return {**table, "fluid": own} if own else table


@dataclass(kw_only=True)
class Probe(Part):
    """A point whose displacement and pressure each result tells."""

    name: str
    point: Vector


@dataclass(kw_only=True)
class Gradient(Part):
    """Goals such as `"force.lid.y"` and the parameters that each is differentiated by."""

    of: Names
    to: Names
    at: str | None = None


@dataclass(kw_only=True)
class Accuracy(Part):
    """Goals whose error is bounded, or known within tolerances: then the server refines the mesh, up to the limits."""

    bound: Names | None = None
    at: str | None = None
    force: Mapping[str, Any] | None = None
    moment: Mapping[str, Any] | None = None
    reaction: Mapping[str, Any] | None = None
    displacement: Mapping[str, Any] | None = None
    max_unknowns: float | None = None
    max_memory: float | None = None
    max_time: float | None = None
    max_rounds: int | None = None


@dataclass(kw_only=True)
class Solver(Part):
    """Numerical settings; none is ever needed."""

    tolerance: float | str | None = None
    quadrature_degree: int | str | None = None
    max_wall_time: float | None = None
    element: str | None = None
    displacement_preconditioner: str | None = None
    p1_solver: str | None = None
    saddle: str | None = None
    contact: str | None = None
    contact_metric: str | None = None
    contact_space: str | None = None
    stability: str | None = None
    on_instability: str | None = None
    response: str | None = None
    report: str | None = None
    penalty: float | str | None = None
    error_estimate: str | None = None


@dataclass(kw_only=True)
class Scene(Part):
    """A whole problem. `mesh` is a file or a `Mesh`, none where `bodies` have files; `materials` are by group."""

    mesh: str | Path | Mesh | None = None
    materials: Mapping[str, Material] = field(default_factory=dict)
    supports: Sequence[Support | Mapping[str, Any]] = ()
    tractions: Sequence[Traction | Mapping[str, Any]] = ()
    pressures: Sequence[Pressure | Mapping[str, Any]] = ()
    body_force: Vector | BodyForce | Mapping[str, Any] | None = None
    obstacles: Sequence[Obstacle | Mapping[str, Any]] = ()
    steps: Sequence[Step | Mapping[str, Any]] = ()
    probes: Sequence[Probe | Mapping[str, Any]] = ()
    kind: str | None = None
    #: What your units are called: length, force, stress.
    units: Mapping[str, str] | None = None
    mesh_scale: float | None = None
    name: str | None = None
    solver: Solver | Mapping[str, Any] | None = None
    manufactured: Mapping[str, str] | None = None
    output: Mapping[str, Any] | None = None
    fluids: Sequence[Fluid | Mapping[str, Any]] = ()
    gradients: Sequence[Gradient | Mapping[str, Any]] = ()
    accuracy: Accuracy | Mapping[str, Any] | None = None
    contacts: Sequence[BodyContact | Mapping[str, Any]] = ()
    ties: Sequence[Tie | Mapping[str, Any]] = ()
    bodies: Sequence[Body | Mapping[str, Any]] = ()

    def as_dict(self) -> dict[str, Any]:
        """The tables of a scene file; a `Mesh` stays as it is."""
        table = super().as_dict()
        force = table.get("body_force")
        return {**table, "body_force": {"value": force}} if isinstance(force, list) else table
