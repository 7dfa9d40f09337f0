"""Scenes with friction that every peer can pose in the same way: a flat rigid tool, linear elasticity, Poisson ratio 0.3.

cube-drag    unit cube, u = 0 on z0; a rough plate presses z1 down by 0.02, then drags it 0.015 along x in three increments
hertz-press  quarter of half a ball, flat top held; a rough plane is pressed up by 0.05 in four increments

Coulomb friction 0.3, shear modulus 1. Each increment is one implicit step: the slip is that since the end of the one before.
The tangential force of hertz-press is that on the quarter: it vanishes for the whole body.
"""
from dataclasses import dataclass

FRICTION, SHEAR, POISSON = 0.3, 1.0, 0.3
YOUNG = 2.0 * SHEAR * (1.0 + POISSON)
LAME = 2.0 * SHEAR * POISSON / (1.0 - 2.0 * POISSON)


@dataclass
class Scene:
    """Sides of the body and what they are for; the tool's plane through `height`, its solid above (1) or below (-1)."""

    held: str
    contact: str
    # Side and the axis that it holds.
    symmetric: tuple
    height: float
    above: float
    # Translation of the tool at the end of each increment.
    path: tuple


SCENES = {
    "cube-drag": Scene("z0", "z1", (), 1.0, 1.0, ((0.0, 0.0, -0.02), *((0.005 * k, 0.0, -0.02) for k in (1, 2, 3)))),
    "hertz-press": Scene(
        "top", "contact", (("x0", 0), ("y0", 1)), -1.0, -1.0, tuple((0.0, 0.0, 0.0125 * k) for k in (1, 2, 3, 4))
    ),
}


def values_of(force, whole_body):
    """Columns of peers.csv of a force on the model."""
    return {
        "value_force": whole_body * abs(force[2]),
        "value_tangential_force": whole_body * (force[0] ** 2 + force[1] ** 2) ** 0.5,
    }
