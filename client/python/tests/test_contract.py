"""The classes and the writer of steps know every key of the contract, and no other."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

import signorini as s
from signorini import _connection, _encode, _program, reports
from signorini.v1 import report_pb2, scene_pb2, step_pb2

# Keys of a support that the message has in one of their own.
SPRINGS = {"stiffness", "rotational_stiffness"}
LOADS = {one.name for one in scene_pb2.SupportLoad.DESCRIPTOR.fields}
CLASSES = [
    (s.LinearElastic, scene_pb2.LinearElastic, {"formulation"}, set()),
    (s.Stokes, scene_pb2.Stokes, {"formulation"}, set()),
    (s.MooneyRivlin, scene_pb2.MooneyRivlin, {"formulation"}, set()),
    (s.NeoHookean, scene_pb2.NeoHookean, {"formulation"}, set()),
    (s.Yeoh, scene_pb2.Yeoh, {"formulation"}, set()),
    (s.Ogden, scene_pb2.Ogden, {"formulation"}, set()),
    (s.Polynomial, scene_pb2.Polynomial, {"formulation"}, set()),
    (s.Gent, scene_pb2.Gent, {"formulation"}, set()),
    (s.ArrudaBoyce, scene_pb2.ArrudaBoyce, {"formulation"}, set()),
    (s.VanDerWaals, scene_pb2.VanDerWaals, {"formulation"}, set()),
    (s.Hyperfoam, scene_pb2.Hyperfoam, {"formulation"}, set()),
    (s.BlatzKo, scene_pb2.BlatzKo, {"formulation"}, set()),
    (s.HalfSpace, scene_pb2.HalfSpace, {"inside"}, set()),
    (s.Sphere, scene_pb2.Sphere, {"inside"}, set()),
    (s.Cylinder, scene_pb2.Cylinder, {"inside"}, set()),
    (s.CappedCylinder, scene_pb2.CappedCylinder, {"inside", "start", "end"}, {"from", "to"}),
    (s.Box, scene_pb2.BoxShape, {"inside"}, set()),
    (s.Torus, scene_pb2.Torus, {"inside"}, set()),
    (s.Cone, scene_pb2.Cone, {"inside"}, set()),
    (s.Surface, scene_pb2.SurfaceShape, {"inside", "file"}, {"surface"}),
    (s.HeightField, scene_pb2.HeightField, {"inside", "file"}, {"grid"}),
    (s.DistanceGrid, scene_pb2.DistanceGrid, {"inside", "file"}, {"grid"}),
    (s.Support, scene_pb2.Support, LOADS, {"load"}),
    (s.Traction, scene_pb2.Traction, set(), set()),
    (s.Pressure, scene_pb2.Pressure, set(), set()),
    (s.Fluid, scene_pb2.Fluid, {"source"}, {"from"}),
    (s.BodyContact, scene_pb2.BodyContact, set(), set()),
    (s.Tie, scene_pb2.Tie, set(), set()),
    (s.Obstacle, scene_pb2.Obstacle, set(), set()),
    (s.Probe, scene_pb2.Probe, set(), set()),
    (s.Gradient, scene_pb2.Gradient, set(), set()),
    (s.Accuracy, scene_pb2.Accuracy, {"force", "moment", "reaction", "displacement"}, {"targets"}),
    (s.Solver, scene_pb2.SolverOptions, set(), {"verify", "tolerance_rule"}),
    (s.Step, step_pb2.LoadStep, set(), set()),
    (s.Move, step_pb2.ObstacleTarget, set(), {"name"}),
    (s.SupportMove, step_pb2.SupportTarget, set(), {"name"}),
    (s.FluidPressure, step_pb2.FluidTarget, {"up_to"}, {"name", "to_blow_off"}),
    (s.TractionChange, step_pb2.TractionTarget, set(), {"name"}),
    (s.Scene, scene_pb2.Scene, {"bodies"}, {"body_force_values"}),
]


@pytest.mark.parametrize(("kind", "message", "own", "other"), CLASSES, ids=lambda one: getattr(one, "__name__", ""))
def test_classes_have_the_fields_of_the_messages(kind: Any, message: Any, own: set[str], other: set[str]) -> None:
    ours = {one.name for one in dataclasses.fields(kind)}
    theirs = {one.name for one in message.DESCRIPTOR.fields}
    assert ours - own == theirs - other


def filled(kind: Any) -> dict[str, Any]:
    """An instance with every key given."""
    values: dict[str, Any] = {one.name: 0.25 for one in dataclasses.fields(kind)}
    vectors = {"point", "normal", "centre", "axis", "half_sizes", "start", "end", "apex", "translation", "rotation"}
    vectors |= {"about", "mu", "alpha", "nu"}
    vectors -= {"mu"} if kind is s.ArrudaBoyce else set()
    values |= dict.fromkeys(vectors & values.keys(), (1, 2.5, 3))
    values |= {name: {"x": 1.0} for name in {"displacement", "force", "moment", *SPRINGS} & values.keys()}
    values |= {"normal": 0.0} if kind is s.Support else {}
    # The program reads files; arrays go round the text.
    values.pop("values", None)
    values |= dict.fromkeys({"inside", "facets", "itself"} & values.keys(), False)
    words = {"formulation": "mixed", "profile": "parabolic", "name": "n", "on": ["a", "b"], "surface": "smooth"}
    words |= {"of": ["force.n.x"], "to": "load", "bound": "force.n.x", "at": "increments"}
    words |= {"file": "tool.stl", "weld": 1e-4, "source": ["a"], "dry": "c", "film": "squeezed-out"}
    words |= {"between": ["a", "b"], "carries": "b"}
    return kind(**{**values, **{key: word for key, word in words.items() if key in values}}).as_dict()


def scene() -> dict[str, Any]:
    """Every key of scenes at once; only the form is read."""
    step = {"increments": 3, "load": 0.5}
    step |= {"obstacle": {"n": filled(s.Move)}, "support": {"n": {**filled(s.SupportMove)}}}
    del step["support"]["n"]["displacement"]
    step |= {"fluid": {"m": {"pressure": 2.0}, "n": {"pressure": "to blow-off", "up_to": 5.0}}}
    linear = filled(s.LinearElastic)
    del linear["young_modulus"]
    materials = [s.Stokes, s.MooneyRivlin, s.NeoHookean, s.Yeoh, s.Ogden, s.Polynomial, s.Gent, s.ArrudaBoyce]
    materials += [s.VanDerWaals, s.Hyperfoam, s.BlatzKo]
    shapes = [s.HalfSpace, s.Sphere, s.Cylinder, s.CappedCylinder, s.Box, s.Torus, s.Cone]
    shapes += [s.Surface, s.HeightField, s.DistanceGrid]
    obstacle = {"name": "n", "on": ["a"], "friction": 0.3, "tresca": 0.1, "surface": "smooth"}
    obstacle |= {"initial_penetration": "reject"}
    solver = dict.fromkeys(filled(s.Solver), "auto")
    solver |= {"tolerance": "discretisation", "max_wall_time": 3.0}
    return {
        "material": {"linear": linear, **{kind.__name__: filled(kind) for kind in materials}},
        "support": [filled(s.Support)],
        "traction": [{"on": "a", "value": [1, 2, 3]}],
        "pressure": [filled(s.Pressure)],
        "fluid": [filled(s.Fluid), {"name": "m", "on": "a", "from": "b", "threshold": "fluid"}],
        "contact": [filled(s.BodyContact), {"name": "m", "between": ["a", "b"]}],
        "tie": [filled(s.Tie), {"name": "n", "between": ["a", "b"]}],
        "obstacle": [{**obstacle, "shape": filled(kind)} for kind in shapes],
        "probe": [filled(s.Probe)],
        "gradient": [filled(s.Gradient)],
        "accuracy": s.Accuracy(
            bound="force.n.x",
            at="steps",
            force={"n": {"x": 0.25}, "m": 0.5},
            moment={"n": {"x": 0.25}},
            reaction={"a": {"y": 0.25}},
            displacement={"n": {"z": 0.25}},
            max_unknowns=2e6,
            max_memory=1e9,
            max_time=60.0,
            max_rounds=3,
        ).as_dict(),
        "solver": solver,
        "step": [step],
        "output": {"fields": _encode.field_names(), "every": 2},
        "manufactured": {"field": "A1m"},
        "body_force": {"value": [0, 0, -1.0]},
    }


def test_every_key_of_the_classes_is_read_by_the_program() -> None:
    tables = scene()
    text = _encode.tomli_w.dumps(tables).encode()
    message = scene_pb2.Scene.FromString(_program.read_scene(text, Path("scene"), ['mesh="a.msh"']))
    assert len(message.materials) == 12
    assert len(message.obstacles) == 10
    assert [one.HasField("threshold") for one in message.fluids] == [True, False]
    assert list(message.output.fields) == [one.number for one in scene_pb2.FieldName.DESCRIPTOR.values if one.number]
    assert message.steps[0] == _encode.load_step(tables["step"][0])


def test_a_scene_of_classes_is_that_of_its_tables(ball: s.Scene) -> None:
    ball.steps = [s.Step(increments=2, obstacles={"ball": s.Move(translation=(0, 0, -0.05))})]
    by_classes, by_tables = _encode.problem(ball), _encode.problem(ball.as_dict())
    assert by_classes.scene == by_tables.scene
    assert by_classes.scene.steps[0].obstacles[0].translation[2] == -0.05
    assert by_classes.scene.mesh == f"meshes/{ball.mesh.digest}"  # type: ignore[union-attr]


def test_bodies_with_files_of_their_own_become_one_mesh() -> None:
    square = Path(__file__).parents[2] / "examples/meshes/square_n16.msh"
    bodies = [s.Body(name="low", mesh=square), s.Body(name="up", mesh=square, translation=(0, 1, 0))]
    ties = [s.Tie(name="seam", between=("low-y1", "up-y0"))]
    problem = _encode.problem(s.Scene(bodies=bodies, ties=ties))
    assert set(problem.mesh.bodies) == {"low-body", "up-body"}
    assert {"low-y1", "up-y0"} <= set(problem.mesh.surfaces)
    assert problem.mesh.points[:, 1].max() == 2.0
    assert problem.scene.mesh == problem.mesh.name
    assert list(problem.scene.ties[0].between) == ["low-y1", "up-y0"]


def test_every_message_of_reports_has_a_view() -> None:
    for name, message in report_pb2.DESCRIPTOR.message_types_by_name.items():
        view = getattr(reports, name)(message._concrete_class())
        assert view.names() == tuple(one.name for one in message.fields)
        assert set(view.as_dict()) == set(view.names())


def test_absent_numbers_are_none_and_enumerations_words() -> None:
    message = report_pb2.StepReport(termination=2, cause=11)
    view = reports.StepReport(message)
    assert (view.termination, view.cause) == ("not_converged", "unstable_equilibrium")
    assert view.error_estimate is None
    message.error_estimate = 0.0
    assert reports.StepReport(message).error_estimate == 0.0


def test_updates_name_the_wrong_key() -> None:
    for step, said in [
        ({"increment": 1}, 'step.increment: unknown key; did you mean "increments"?'),
        ({"obstacle": {"a": {"translate": 1}}}, "step.obstacle.a.translate: unknown key; did you mean"),
        ({"obstacle": {"a": [0, 0]}}, "step.obstacle.a.translation: a list of three numbers is expected"),
        ({"support": {"a": {"displacement": {"w": 1.0}}}}, "step.support.a.displacement.w: unknown key"),
        ({"fluid": {"a": {"pressure": "to blow-off"}}}, "step.fluid.a.up_to: required key is missing"),
        ({"fluid": {"a": {"pressure": 1, "up_to": 2}}}, 'step.fluid.a.up_to: goes with pressure = "to blow-off" only'),
        ({"fluid": {"a": "to blowoff"}}, 'step.fluid.a.pressure: a number or "to blow-off" is expected'),
    ]:
        with pytest.raises(s.errors.SceneError) as caught:
            _encode.load_step(step)
        assert str(caught.value).startswith(said)


def test_pressures_of_fluids_are_numbers_tables_or_a_word() -> None:
    by_class = s.Step(fluids={"water": 2.0, "oil": s.FluidPressure(pressure="to blow-off", up_to=50)})
    by_table = {"fluids": {"water": {"pressure": 2}, "oil": {"pressure": "to blow-off", "up_to": 50.0}}}
    message = _encode.load_step(by_class)
    assert message == _encode.load_step(by_table)
    loads = {one.name: (one.WhichOneof("load"), getattr(one, one.WhichOneof("load"))) for one in message.fluids}
    assert loads == {"water": ("pressure", 2.0), "oil": ("to_blow_off", 50.0)}


def test_leak_paths_are_rows_of_points() -> None:
    path = report_pb2.LeakPath(margin=3.5, points=[0, 1, 2, 3, 4, 5], pressures=[1.0, 2.0])
    water = report_pb2.FluidResult(pressure=2.0, tightness=report_pb2.TIGHTNESS_LEAKS, leak_path=path)
    dry = report_pb2.FluidResult(tightness=report_pb2.TIGHTNESS_TIGHT)
    report = reports.StepReport(report_pb2.StepReport(fluids={"water": water, "oil": dry}))
    increment = s.Increment(sequence=1, event=1, last=True, report=report, fields={})
    found = increment.leak_path("water")
    assert found is not None
    assert (found[0].shape, found[1].tolist()) == ((2, 3), [1.0, 2.0])
    assert increment.leak_path("oil") is None
    assert increment.fluids["water"].tightness == "leaks"


def test_goals_have_bounds_and_derivatives_or_say_why_not() -> None:
    bound = report_pb2.GoalBound(total=0.5, mesh=0.5, estimate=-0.25)
    goal = report_pb2.GoalResult(value=-2.0, derivatives={"load": 3.0, "material.a.c10": 1.5}, bound=bound)
    report = reports.StepReport(report_pb2.StepReport(goals={"force.lid.y": goal}))
    increment = s.Increment(sequence=1, event=1, last=True, report=report, fields={})
    assert increment.gradient("force.lid.y") == {"load": 3.0, "material.a.c10": 1.5}
    told = increment.goal("force.lid.y").bound
    assert told is not None
    assert (told.total, told.estimate) == (0.5, -0.25)
    with pytest.raises(s.errors.GoalError, match=r"there are force\.lid\.y"):
        increment.gradient("force.lid.x")
    refused = reports.StepReport(report_pb2.StepReport(goals_refused="the scene has friction"))
    increment = s.Increment(sequence=1, event=1, last=True, report=refused, fields={})
    with pytest.raises(s.errors.GoalError, match="the scene has friction"):
        increment.goal("force.lid.y")


def test_pauses_double_up_to_two_seconds_until_the_patience_ends() -> None:
    pauses = list(_connection.pauses(9.0))
    assert pauses == pytest.approx([0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 2.0, 1.85])
    assert list(_connection.pauses(0.0)) == []
