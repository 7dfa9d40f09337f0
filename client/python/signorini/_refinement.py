"""Meshes that the server refines until goals are known as well as a scene asks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .v1 import mesh_service_pb2, scene_pb2

__all__ = ["Round", "RoundGoal", "is_asked", "rounds_of", "word"]


@dataclass(frozen=True)
class RoundGoal:
    """A goal on one mesh, where the last step ends."""

    #: Its value.
    value: float
    #: What the error is not above: of the mesh, of the solver and of flat facets together.
    bound: float
    #: The exact value less this one, estimated.
    estimate: float
    #: The part of flat facets in the bound.
    geometry: float
    #: Largest error over the absolute value that was asked for.
    tolerance: float


@dataclass(frozen=True)
class Round:
    """One mesh with the errors of its goals."""

    #: From 1, the mesh of the scene.
    round: int
    #: Cells of the mesh.
    cells: int
    #: Unknowns, those of contact included.
    unknowns: int
    #: Goals by their names.
    goals: Mapping[str, RoundGoal]
    #: Wall seconds, preparation included.
    seconds: float
    #: Of the last mesh the word why there is none after it, `reached` where nothing is left; else empty.
    end: str = ""
    #: The same as a sentence.
    why: str = ""


def is_asked(scene: scene_pb2.Scene) -> bool:
    """Whether a scene asks for a mesh that is fine enough for its goals."""
    return len(scene.accuracy.targets) > 0


def word(refined: mesh_service_pb2.RefinedMesh) -> str:
    """Why a mesh is not refined further."""
    return mesh_service_pb2.RefinementEnd.Name(refined.end).removeprefix("REFINEMENT_END_").lower()


def rounds_of(told: list[mesh_service_pb2.RefinementRound], refined: mesh_service_pb2.RefinedMesh) -> tuple[Round, ...]:
    """The meshes of a refinement, the last one with why it is that."""
    rounds = []
    for index, one in enumerate(told, 1):
        goals = {
            goal.goal: RoundGoal(goal.value, goal.bound, goal.estimate, goal.geometry, goal.tolerance)
            for goal in one.goals
        }
        end, why = (word(refined), refined.why) if index == len(told) else ("", "")
        rounds.append(Round(one.round, one.cell_count, one.unknown_count, goals, one.seconds, end, why))
    return tuple(rounds)
