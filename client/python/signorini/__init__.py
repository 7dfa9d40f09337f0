"""Contact of nearly incompressible bodies: seals, tyres, soft robots, tissue.

    import signorini as s
    r = s.solve(s.example("o-ring"))
    print(r.obstacles["lid"].force)

Without an address (`server=...`, or `SIGNORINI_SERVER`) a server of our own starts and ends with the
interpreter. `signorini.aio` is the asynchronous twin, `signorini.v1` the messages of the contract.
"""

from . import errors
from ._session import Pending, Session
from ._study import read_study, study
from ._surfaces import write_grid
from ._values import Values, write_values
from .client import Client, connect, plan, session, solve
from .errors import SignoriniError, SignoriniWarning
from .mesh import Mesh, boundary
from .results import Increment, Iteration, Result
from .scene import (
    Accuracy,
    ArrudaBoyce,
    BlatzKo,
    Body,
    BodyContact,
    BodyForce,
    Box,
    CappedCylinder,
    Cone,
    Cylinder,
    DistanceGrid,
    Fluid,
    FluidPressure,
    Gent,
    Gradient,
    HalfSpace,
    HeightField,
    Hyperfoam,
    LinearElastic,
    MooneyRivlin,
    Move,
    NeoHookean,
    Obstacle,
    Ogden,
    Polynomial,
    Pressure,
    Probe,
    Scene,
    Solver,
    Sphere,
    Step,
    Stokes,
    Support,
    SupportMove,
    Surface,
    Tie,
    Torus,
    Traction,
    TractionChange,
    VanDerWaals,
    Yeoh,
)
from .scenes import example

__all__ = [
    "Accuracy",
    "ArrudaBoyce",
    "BlatzKo",
    "Body",
    "BodyContact",
    "BodyForce",
    "Box",
    "CappedCylinder",
    "Client",
    "Cone",
    "Cylinder",
    "DistanceGrid",
    "Fluid",
    "FluidPressure",
    "Gent",
    "Gradient",
    "HalfSpace",
    "HeightField",
    "Hyperfoam",
    "Increment",
    "Iteration",
    "LinearElastic",
    "Mesh",
    "MooneyRivlin",
    "Move",
    "NeoHookean",
    "Obstacle",
    "Ogden",
    "Pending",
    "Polynomial",
    "Pressure",
    "Probe",
    "Result",
    "Scene",
    "Session",
    "SignoriniError",
    "SignoriniWarning",
    "Solver",
    "Sphere",
    "Step",
    "Stokes",
    "Support",
    "SupportMove",
    "Surface",
    "Tie",
    "Torus",
    "Traction",
    "TractionChange",
    "Values",
    "VanDerWaals",
    "Yeoh",
    "boundary",
    "connect",
    "errors",
    "example",
    "plan",
    "read_study",
    "session",
    "solve",
    "study",
    "write_grid",
    "write_values",
]
