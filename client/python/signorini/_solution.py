"""The numbers of a solve: its increments with their reports and fields, and tables of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from ._encode import field_names
from ._refinement import Round
from .errors import FieldError, GoalError, NotConvergedError
from .mesh import Mesh
from .reports import (
    BodyContactResult,
    FluidResult,
    GoalResult,
    IterationReport,
    ObstacleResult,
    Plan,
    ProbeResult,
    StepReport,
    SupportResult,
    TieResult,
    Warning,
)
from .v1 import report_pb2

if TYPE_CHECKING:
    from .v1.scene_pb2 import Scene

__all__ = ["Increment", "Iteration", "Solution"]

Kind = TypeVar("Kind", bound="Solution")

Field = npt.NDArray[np.float64]

#: The kind of the warning of an obstacle that is away from the body.
UNTOUCHED = "untouched_obstacle"


class Fields(dict[str, Field]):
    """Arrays by name, which say of one that is not there how it is asked for."""

    def __missing__(self, name: str) -> Field:
        """There is none of that name."""
        if name not in field_names():
            raise FieldError(f'"{name}" is no field: known are {", ".join(field_names())}')
        there = ", ".join(sorted(self)) or "none"
        raise FieldError(
            f'no field "{name}" in this increment, there are {there}: name it in `output.fields` of the scene, '
            "or in fields=[...] of the call"
        )


@dataclass(frozen=True)
class Iteration:
    """Statistics of a step that runs."""

    sequence: int
    report: IterationReport
    #: Iterations that were left out since the one before.
    skipped: int


@dataclass(frozen=True, eq=False)
class Increment:
    """The result of one increment: `report` says everything, the properties what is asked most."""

    sequence: int
    event: int
    #: Whether it is the last of its step.
    last: bool
    report: StepReport
    #: Arrays by name, [rows, components] or [rows]; read-only where nothing was copied.
    fields: Mapping[str, Field]
    #: Some fields that were due were not made or are no longer kept.
    fields_dropped: bool = False

    @property
    def obstacles(self) -> Mapping[str, ObstacleResult]:
        """What each obstacle does to the body."""
        # A map of the wire has no order.
        return dict(sorted(self.report.obstacles.items()))

    @property
    def supports(self) -> Mapping[str, SupportResult]:
        """The reaction of each support."""
        return self.report.supports

    @property
    def probes(self) -> Mapping[str, ProbeResult]:
        """The values at each probe."""
        return self.report.probes

    @property
    def fluids(self) -> Mapping[str, FluidResult]:
        """What each fluid does, and how near it is to a leak."""
        return dict(sorted(self.report.fluids.items()))

    @property
    def contacts(self) -> Mapping[str, BodyContactResult]:
        """What bodies do to each other, by the names of their contacts."""
        return dict(sorted(self.report.contacts.items()))

    @property
    def ties(self) -> Mapping[str, TieResult]:
        """What ties between bodies carry, by their names."""
        return dict(sorted(self.report.ties.items()))

    def leak_path(self, fluid: str) -> tuple[Field, Field] | None:
        """Points of the path on which a fluid leaks first, [points, 3], and the pressure at each, [points].

        None where nothing must stay dry, or the fluid cannot get there.
        """
        path = self.fluids[fluid].leak_path
        return None if path is None else (path.points, path.pressures)

    @property
    def goals(self) -> Mapping[str, GoalResult]:
        """Goals by name, such as `force.lid.y`, with what was asked of them."""
        return dict(sorted(self.report.goals.items()))

    def goal(self, name: str) -> GoalResult:
        """A goal; of one that has no answer why."""
        found = self.goals.get(name)
        if found is None:
            refused = self.report.goals_refused
            there = ", ".join(self.goals) or "none"
            raise GoalError(f'no goal "{name}": {refused or f"there are {there}; name it in the scene"}')
        return found

    def gradient(self, goal: str) -> Mapping[str, float]:
        """Derivatives of a goal by parameter, as the scene names them under `gradient`; without any, why."""
        found = self.goal(goal).derivatives
        if not found and self.report.goals_refused:
            raise GoalError(f'no derivatives of "{goal}": {self.report.goals_refused}')
        return dict(sorted(found.items()))

    @property
    def converged(self) -> bool:
        """Whether all criteria are met."""
        return self.report.termination == "converged"

    def contact_path(self, obstacle: str, interval: int | None = None) -> tuple[Field, Field]:
        """Arc lengths and contact pressures along the surface of a section under an obstacle.

        Both [points], of one interval of contact, numbered as in `contact_intervals`, or of all; empty without
        contact. Needs the field `contact_path`, which scenes in the plane and about an axis have.
        """
        path = self.fields.get("contact_path")
        if path is None:
            raise FieldError("no field contact_path: scenes in space have none; else ask for it with fields=[...]")
        names = [pose.name for pose in self.report.obstacle_poses]
        if obstacle not in names:
            raise KeyError(f'no obstacle "{obstacle}": there are {", ".join(names) or "none"}')
        own = path[path[:, 0] == names.index(obstacle)]
        if interval is not None:
            own = own[own[:, 1] == interval]
        return own[:, 2], own[:, 3]

    def __repr__(self) -> str:
        report = self.report
        forces = ", ".join(f"{name} {np.array2string(one.force, precision=6)}" for name, one in self.obstacles.items())
        return f"Increment(step {report.step}, increment {report.increment}: {report.termination}; {forces})"


class Solution(Sequence[Increment]):
    """All increments of a solve, in order. What an increment says, the solution says of its last one."""

    def __init__(
        self, scene: Scene, mesh: Mesh, plan: Plan, increments: Sequence[Increment], rounds: Sequence[Round] = ()
    ) -> None:
        self.scene = scene
        self.mesh = mesh
        self.plan = plan
        self.increments = list(increments)
        #: Meshes on the way to this one, where the scene asks for one that is fine enough.
        self.rounds = tuple(rounds)

    def __getitem__(self, index: Any) -> Any:
        """An increment, or a list of some."""
        return self.increments[index]

    def __len__(self) -> int:
        """How many increments there are."""
        return len(self.increments)

    def __iter__(self) -> Iterator[Increment]:
        """The increments in order."""
        return iter(self.increments)

    @property
    def last(self) -> Increment:
        """The last increment."""
        return self.increments[-1]

    @property
    def report(self) -> StepReport:
        """Everything that the last increment says."""
        return self.last.report

    @property
    def obstacles(self) -> Mapping[str, ObstacleResult]:
        """What each obstacle does to the body at the end."""
        return self.last.obstacles

    @property
    def supports(self) -> Mapping[str, SupportResult]:
        """The reaction of each support at the end."""
        return self.last.supports

    @property
    def probes(self) -> Mapping[str, ProbeResult]:
        """The values at each probe at the end."""
        return self.last.probes

    @property
    def fluids(self) -> Mapping[str, FluidResult]:
        """What each fluid does at the end, and how near it is to a leak."""
        return self.last.fluids

    @property
    def contacts(self) -> Mapping[str, BodyContactResult]:
        """What bodies do to each other at the end, by the names of their contacts."""
        return self.last.contacts

    @property
    def ties(self) -> Mapping[str, TieResult]:
        """What ties between bodies carry at the end, by their names."""
        return self.last.ties

    def leak_path(self, fluid: str) -> tuple[Field, Field] | None:
        """The path on which a fluid leaks first at the end; see `Increment.leak_path`."""
        return self.last.leak_path(fluid)

    @property
    def goals(self) -> Mapping[str, GoalResult]:
        """Goals at the end; see `Increment.goals`."""
        return self.last.goals

    def goal(self, name: str) -> GoalResult:
        """A goal at the end; see `Increment.goal`."""
        return self.last.goal(name)

    def gradient(self, goal: str) -> Mapping[str, float]:
        """Derivatives of a goal at the end; see `Increment.gradient`."""
        return self.last.gradient(goal)

    @property
    def fields(self) -> Mapping[str, Field]:
        """The fields at the end."""
        return self.last.fields

    def contact_path(self, obstacle: str, interval: int | None = None) -> tuple[Field, Field]:
        """Arc lengths and contact pressures at the end; see `Increment.contact_path`."""
        return self.last.contact_path(obstacle, interval)

    @property
    def converged(self) -> bool:
        """Whether every increment is."""
        return all(one.converged for one in self.increments)

    @cached_property
    def warnings(self) -> list[Warning]:
        """What a mechanic would doubt, each once; obstacles that were waited for and met are none."""
        areas = [(name, one.contact_area) for each in self.increments for name, one in each.obstacles.items()]
        met = {name for name, area in areas if area > 0}
        all_told = (one for increment in self.increments for one in increment.report.warnings)
        told = [one for one in all_told if one.kind != UNTOUCHED or one.subject not in met]
        known = {one.subject for one in told if one.kind == UNTOUCHED}
        never = sorted({name for name, _ in areas} - met - known)
        return [*{one.message: one for one in told}.values(), *map(never_touched, never)]

    def check(self: Kind) -> Kind:
        """Itself, or `NotConvergedError` with the first increment that is not converged."""
        for one in self.increments:
            if not one.converged:
                report = one.report
                cause = f" ({report.cause})" if report.cause else ""
                where = f"step {report.step}, increment {report.increment}, load {report.load:g}"
                raise NotConvergedError(f"{report.termination}{cause}: {where}")
        return self

    def forces(self, obstacle: str) -> Field:
        """The force of an obstacle on the body in every increment, [increments, 3]."""
        return np.array([one.obstacles[obstacle].force for one in self.increments])

    def translations(self, obstacle: str) -> Field:
        """Where an obstacle is in every increment, from its first pose, [increments, 3]."""
        poses = ({pose.name: pose for pose in one.report.obstacle_poses} for one in self.increments)
        return np.array([pose[obstacle].translation for pose in poses])

    def travel(self, obstacle: str) -> tuple[Field, Field] | None:
        """How far an obstacle went along its last translation, and its force along it; None if it stays.

        Both [increments]; the force is positive where the obstacle pushes the body ahead of it.
        """
        path = self.translations(obstacle)
        length = float(np.linalg.norm(path[-1]))
        if length == 0.0:
            return None
        along = path[-1] / length
        return path @ along, self.forces(obstacle) @ along

    def table(self) -> dict[str, list[Any]]:
        """Columns by name, one row an increment: what `pandas.DataFrame` takes."""
        rows = [row(one) for one in self.increments]
        # Goals may be those of ends of steps alone.
        names = dict.fromkeys(name for one in rows for name in one)
        return {name: [one.get(name) for one in rows] for name in names}

    def __repr__(self) -> str:
        state = "converged" if self.converged else f"not converged ({self.report.cause})"
        return f"Result({self.plan.name}: {len(self)} increments, {state}; {self.last if self.increments else ''})"


def never_touched(name: str) -> Warning:
    """Of an obstacle that no increment doubts, as one that moves away from the body."""
    said = f"obstacle `{name}` touched nothing in any increment: does it travel towards the body?"
    return Warning(report_pb2.Warning(kind=UNTOUCHED, subject=name, message=said))


OF_CONTACT = (
    "force_error",
    "contact_area",
    "max_pressure",
    "deformed_contact_area",
    "contact_width",
    "mean_pressure",
    "peak_pressure",
)
"""Numbers of an obstacle in the table."""

BETWEEN_BODIES = ("contact_area", "contact_width", "mean_pressure", "peak_pressure")
"""Numbers of a contact between bodies in the table."""

OF_FLUID = ("pressure", "tightness", "blow_off_low", "blow_off_high", "wet_area", "conductance", "flow_rate")
OF_LEAK = ("margin", "margin_over_pressure", "sealed_width")
"""What the table says of a fluid, and of its leak path."""


def row(increment: Increment) -> dict[str, Any]:
    """One row of the table."""
    report = increment.report
    names = ("step", "increment", "time", "load", "termination", "cause")
    cells: dict[str, Any] = {name: getattr(report, name) for name in names}
    for name, obstacle in increment.obstacles.items():
        for axis, value in zip("xyz", obstacle.force.tolist(), strict=False):
            cells[f"{name}.force_{axis}"] = value
        for key in OF_CONTACT:
            cells[f"{name}.{key}"] = getattr(obstacle, key)
    for name, fluid in increment.fluids.items():
        cells |= {f"fluid.{name}.{key}": getattr(fluid, key) for key in OF_FLUID}
        path = fluid.leak_path
        cells |= {f"fluid.{name}.{key}": getattr(path, key) if path else None for key in OF_LEAK}
    for name, goal in increment.goals.items():
        cells[f"goal.{name}"] = goal.value
        if goal.bound is not None:
            cells |= {f"goal.{name}.bound": goal.bound.total, f"goal.{name}.estimate": goal.bound.estimate}
        cells |= {f"goal.{name} by {key}": value for key, value in sorted(goal.derivatives.items())}
    for name, contact in increment.contacts.items():
        for axis, value in zip("xyz", contact.force.tolist(), strict=False):
            cells[f"contact.{name}.force_{axis}"] = value
        cells |= {f"contact.{name}.{key}": getattr(contact, key) for key in BETWEEN_BODIES}
    for name, tie in increment.ties.items():
        for axis, value in zip("xyz", tie.force.tolist(), strict=False):
            cells[f"tie.{name}.force_{axis}"] = value
        cells |= {f"tie.{name}.{key}": getattr(tie, key) for key in ("area", "gap", "peak_traction")}
    more = ("strain_energy", "volume_ratio", "min_jacobian", "max_penetration", "error_estimate")
    cells |= {name: getattr(report, name) for name in (*more, "krylov_iterations")}
    return {**cells, "seconds": report.seconds.total}
