"""Scenes and steps as the messages that the service takes.

Scenes are read by the program of the package. Steps, which a loop sends by the hundred, are
written here: the same keys, checked against the messages themselves.
"""

from __future__ import annotations

import contextlib
import difflib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from . import _program
from ._refinement import Round
from ._surfaces import Surface, read_surfaces
from ._values import Arrays, step_values
from .errors import SceneError, Violation
from .mesh import Mesh
from .scene import Scene, Step, plain
from .v1 import scene_pb2, step_pb2

#: Stands for the mesh of a scene whose mesh is given as arrays.
ARRAYS = "arrays"

SceneLike = str | Path | Mapping[str, Any] | Scene


@dataclass
class Problem:
    """A scene with its mesh, ready to be sent."""

    scene: scene_pb2.Scene
    mesh: Mesh
    surfaces: Sequence[Surface] = ()
    #: Meshes on the way to this one, where a scene asks for one that is fine enough.
    rounds: Sequence[Round] = ()


def problem(scene: SceneLike, mesh: Mesh | Any | None = None, changes: Mapping[str, Any] | None = None) -> Problem:
    """Reads a scene: a file, a dictionary with the keys of one, or a `Scene`."""
    arrays_of_scene = Arrays()
    text, path, own = source(scene, arrays_of_scene)
    mesh = mesh if mesh is not None else own
    settings = [f"{key}={toml(value)}" for key, value in (changes or {}).items()]
    if mesh is not None:
        settings.append(f"mesh={toml(ARRAYS)}")
    message = scene_pb2.Scene.FromString(_program.read_scene(text, path, settings))
    arrays_of_scene.put(message)
    if mesh is not None:
        arrays = as_mesh(mesh)
    elif message.mesh:
        arrays = Mesh.read(message.mesh)
    else:
        arrays = Mesh.from_upload(_program.read_bodies(text, path, settings))
    message.mesh = arrays.name
    return Problem(message, arrays, read_surfaces(message))


def source(scene: SceneLike, arrays: Arrays) -> tuple[bytes, Path, Any]:
    """The text of a scene, the path that names it, and its mesh where that is no file.

    Values that are arrays go round the text, into `arrays`.
    """
    if isinstance(scene, (str, Path)):
        path = Path(scene)
        return path.read_bytes(), path, None
    tables = dict(scene.as_dict() if isinstance(scene, Scene) else plain(scene))
    mesh = tables.get("mesh")
    if mesh is None or isinstance(mesh, (str, Path)):
        mesh = None
    else:
        tables.pop("mesh", None)
    arrays.take(tables)
    # A name in the working directory: a relative mesh begins there.
    return tomli_w.dumps(tables).encode(), Path("scene"), mesh


def as_mesh(mesh: Any) -> Mesh:
    """A `Mesh`, a path, or what meshio reads."""
    if isinstance(mesh, Mesh):
        return mesh
    return Mesh.read(mesh) if isinstance(mesh, (str, Path)) else Mesh.from_meshio(mesh)


def toml(value: Any) -> str:
    """A value of TOML on one line."""
    value = plain(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return tomli_w.dumps({"value": value}).removeprefix("value = ").rstrip("\n")


StepLike = Step | Mapping[str, Any]
MoveLike = Any


def load_step(step: StepLike) -> step_pb2.LoadStep:
    """The message of a step; names of keys as in scene files or in `Step`."""
    table = step.as_dict() if isinstance(step, Step) else plain(step)
    singular = {"obstacles": "obstacle", "supports": "support", "tractions": "traction", "fluids": "fluid"}
    table = {singular.get(key, key): one for key, one in table.items()}
    known("step", table, ("increments", "load", "obstacle", "support", "traction", "fluid", "body_force"))
    return step_pb2.LoadStep(
        increments=table.get("increments"),
        load=table.get("load"),
        obstacles=obstacle_targets(table.get("obstacle", {})),
        supports=[target(step_pb2.SupportTarget, "support", *one) for one in table.get("support", {}).items()],
        tractions=[target(step_pb2.TractionTarget, "traction", *one) for one in table.get("traction", {}).items()],
        body_force=body_force(table.get("body_force")),
        fluids=[fluid_target(*one) for one in table.get("fluid", {}).items()],
    )


#: The word of a pressure that rises until the fluid leaks.
TO_BLOW_OFF = "to blow-off"


def fluid_target(name: str, given: Any) -> step_pb2.FluidTarget:
    """Where the pressure of a fluid leads; a bare number is a pressure."""
    given = plain(given)
    path = f"step.fluid.{name}"
    table = given if isinstance(given, Mapping) else {"pressure": given}
    known(path, table, ("pressure", "up_to"))
    pressure, most = table.get("pressure"), table.get("up_to")
    if pressure == TO_BLOW_OFF:
        if most is None:
            raise fault(f"{path}.up_to", "required key is missing: the pressure at which the step ends without a leak")
        return step_pb2.FluidTarget(name=name, to_blow_off=checked(f"{path}.up_to", most))
    if most is not None:
        raise fault(f"{path}.up_to", f'goes with pressure = "{TO_BLOW_OFF}" only; leave it out')
    if not isinstance(pressure, (int, float)):
        raise fault(f"{path}.pressure", f'a number or "{TO_BLOW_OFF}" is expected, found {pressure!r}')
    return step_pb2.FluidTarget(name=name, pressure=pressure)


def body_force(given: Any) -> Any:
    """New values of the body force, `{"values": ...}`."""
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise fault("step.body_force", "a table with `values` is expected")
    known("step.body_force", given, ("values",))
    return step_values(dict(given), "step.body_force")


def obstacle_targets(moves: Mapping[str, MoveLike]) -> list[step_pb2.ObstacleTarget]:
    """Targets of obstacles by name; a bare vector is a translation."""
    return [translation(name, move) for name, move in moves.items()]


def translation(name: str, move: MoveLike) -> step_pb2.ObstacleTarget:
    """A target; the usual one, a bare vector of three numbers, without a detour."""
    vector = move.tolist() if isinstance(move, np.ndarray) else move
    if isinstance(vector, (tuple, list)) and len(vector) == 3:
        with contextlib.suppress(TypeError):
            return step_pb2.ObstacleTarget(name=name, translation=vector)
    one: step_pb2.ObstacleTarget = target(step_pb2.ObstacleTarget, "obstacle", name, move)
    return one


def target(kind: Any, what: str, name: str, given: Any) -> Any:
    """One target."""
    given = plain(given)
    table = {"translation": given} if isinstance(given, list) else given
    path = f"step.{what}.{name}"
    if not isinstance(table, Mapping):
        raise fault(path, f"a table or a translation is expected, found {given!r}")
    names = [one.name for one in kind.DESCRIPTOR.fields if one.name != "name"]
    known(path, table, names)
    table = dict(table)
    rows = step_values(table, path) if "values" in table else None
    values = {key: checked(f"{path}.{key}", one) for key, one in table.items()}
    return kind(name=name, **values) if rows is None else kind(name=name, values=rows, **values)


def checked(path: str, value: Any) -> Any:
    """A number, a vector of three numbers or named components."""
    if isinstance(value, Mapping):
        known(path, value, ("x", "y", "z"))
        return step_pb2.Components(**value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        if len(value) != 3 or not all(isinstance(one, (int, float)) for one in value):
            raise fault(path, f"a list of three numbers is expected, found {value!r}")
        return value
    if not isinstance(value, (int, float)):
        raise fault(path, f"a number is expected, found {value!r}")
    return value


def known(path: str, table: Mapping[str, Any], names: Iterable[str]) -> None:
    """Refuses keys that are not known."""
    for key in table:
        if key not in names:
            near = difflib.get_close_matches(key, names, 1)
            hint = f'did you mean "{near[0]}"?' if near else f"known keys are {', '.join(names)}"
            raise fault(f"{path}.{key}", f"unknown key; {hint}")


def fault(path: str, message: str) -> SceneError:
    """One wrong key."""
    return SceneError(message, "SCENE_INVALID", "INVALID_ARGUMENT", {}, (Violation(path, message),))


def field_numbers(names: Iterable[str]) -> list[int]:
    """Numbers of fields by name."""
    values = scene_pb2.FieldName.DESCRIPTOR.values_by_name
    numbers = []
    for name in names:
        found = values.get(f"FIELD_NAME_{name.upper()}")
        if found is None or found.number == 0:
            raise fault("output.fields", f'"{name}" is not known; known are {", ".join(field_names())}')
        numbers.append(found.number)
    return numbers


def field_names() -> list[str]:
    """Names of all fields."""
    values = scene_pb2.FieldName.DESCRIPTOR.values
    return [one.name.removeprefix("FIELD_NAME_").lower() for one in values if one.number]
