"""Values of another code: arrays, one row a node, facet or cell, as they travel.

Nodes are numbered as the rows of displacement: the vertices of the mesh, then the middles of its
edges. Without numbers rows belong to the nodes of what they act on, ascending.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import SceneError, Violation
from .v1 import array_pb2, scene_pb2

#: Places of rows by name.
PLACES = {
    "nodes": array_pb2.VALUE_PLACE_NODES,
    "facets": array_pb2.VALUE_PLACE_FACETS,
    "cells": array_pb2.VALUE_PLACE_CELLS,
}


@dataclass(kw_only=True)
class Values:
    """Rows [rows, 3] (or [rows, 2] in the plane) of nodes, facets or cells with these numbers."""

    rows: npt.ArrayLike
    numbers: npt.ArrayLike | None = None
    place: str = "nodes"

    def message(self, path: str) -> Any:
        """As it travels; `path` is the key in messages of faults."""
        rows = np.asarray(self.rows, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] not in (2, 3):
            raise wrong(path, f"an array [rows, 3] is expected, found {list(rows.shape)}")
        if self.place not in PLACES:
            raise wrong(path, f"`{self.place}` is not known; known are {', '.join(PLACES)}")
        padded = np.zeros((len(rows), 3))
        padded[:, : rows.shape[1]] = rows
        return array_pb2.Values(
            place=PLACES[self.place], numbers=self._numbers(path, len(rows)), rows=padded.astype("<f8").tobytes()
        )

    def _numbers(self, path: str, count: int) -> bytes:
        if self.numbers is None:
            return b""
        numbers = np.asarray(self.numbers)
        if numbers.shape != (count,) or not np.issubdtype(numbers.dtype, np.integer):
            raise wrong(path, f"{count} rows need as many whole numbers, found {numbers.dtype} {list(numbers.shape)}")
        return numbers.astype("<i4").tobytes()


def wrong(path: str, message: str) -> SceneError:
    """One wrong key."""
    return SceneError(message, "SCENE_INVALID", "INVALID_ARGUMENT", {}, (Violation(path, message),))


def as_message(given: Any, path: str) -> Any:
    """The message of values: `Values`, an array, or a mapping of their keys."""
    if isinstance(given, Mapping):
        given = Values(**given)
    return (given if isinstance(given, Values) else Values(rows=given)).message(path)


def write_values(path: str | Path, values: Values) -> None:
    """Writes the file that the key `values` of a scene names."""
    rows, numbers = np.asarray(values.rows, dtype=float), np.asarray(values.numbers)
    if rows.ndim != 2 or rows.shape[1] != 3 or numbers.shape != (len(rows),):
        raise ValueError(f"rows [rows, 3] and one number each are expected, found {rows.shape} and {numbers.shape}")
    lines = [f"{values.place.removesuffix('s')}, x, y, z"]
    lines += [
        f"{number}, {x!r}, {y!r}, {z!r}" for number, (x, y, z) in zip(numbers.tolist(), rows.tolist(), strict=True)
    ]
    Path(path).write_text("\n".join(lines) + "\n")


class Arrays:
    """Arrays of a scene's tables, which the text of a scene has no place for, on their way round it."""

    def __init__(self) -> None:
        self._found: list[tuple[str, Callable[[scene_pb2.Scene], Any], Any]] = []

    def take(self, tables: dict[str, Any]) -> None:
        """Takes the arrays out of the tables of a scene."""
        for index, table in enumerate(tables.get("support", ())):
            if self._take(f"support[{index}]", partial(support_of, index=index), table):
                table.setdefault("displacement", {"x": 0.0, "y": 0.0, "z": 0.0})
        for index, table in enumerate(tables.get("traction", ())):
            if self._take(f"traction[{index}]", partial(traction_of, index=index), table):
                table.setdefault("value", [0.0, 0.0, 0.0])
        force = tables.get("body_force", {})
        if self._take("body_force", lambda scene: scene.body_force_values, force):
            force.setdefault("value", [0.0, 0.0, 0.0])
        for number, step in enumerate(tables.get("step", ())):
            self._take_step(number, step)

    def _take_step(self, number: int, step: dict[str, Any]) -> None:
        """The arrays of a step: its targets are put in whole, after those that the text has."""
        for plural, kind in (("supports", "support"), ("tractions", "traction")):
            for name, table in list(step.get(kind, {}).items()):
                find = partial(target_of, step=number, kind=plural, name=name)
                if self._take(f"step[{number}].{kind}.{name}", find, table) and not table:
                    del step[kind][name]
        force = step.get("body_force", {})
        find_force = partial(force_of, step=number)
        if self._take(f"step[{number}].body_force", find_force, force):
            del step["body_force"]

    def _take(self, path: str, find: Callable[[scene_pb2.Scene], Any], table: Any) -> bool:
        given = table.get("values") if isinstance(table, dict) else None
        if given is None or isinstance(given, (str, Path)):
            return False
        del table["values"]
        self._found.append((f"{path}.values", find, given))
        return True

    def put(self, scene: scene_pb2.Scene) -> None:
        """Puts them into the message of the scene."""
        for path, find, given in self._found:
            find(scene).CopyFrom(as_message(given, path))


def support_of(scene: scene_pb2.Scene, index: int) -> Any:
    """The values of a support."""
    return scene.supports[index].values


def traction_of(scene: scene_pb2.Scene, index: int) -> Any:
    """The values of a traction."""
    return scene.tractions[index].values


def force_of(scene: scene_pb2.Scene, step: int) -> Any:
    """The values of the body force of a step."""
    return scene.steps[step].body_force


def target_of(scene: scene_pb2.Scene, step: int, kind: str, name: str) -> Any:
    """The values of a target of a step, which is made where the text had nothing of it."""
    targets = getattr(scene.steps[step], kind)
    found = next((one for one in targets if one.name == name), None)
    return (targets.add(name=name) if found is None else found).values


def step_values(table: dict[str, Any], path: str) -> Any:
    """The values of a target, taken out of its table; none where there are none."""
    given = table.pop("values", None)
    if isinstance(given, (str, Path)):
        raise wrong(f"{path}.values", f"an array is expected, found the file {json.dumps(str(given))}")
    return None if given is None else as_message(given, f"{path}.values")
