"""What the scripts of this folder share: those of `../figures` and `../peers`, meshes of grids, scenes of pairs.

`run` solves a scene of keys; grids are `Grid` of `../peers/pair_bodies.py`, their groups BODY-SIDE.
"""
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
for name in ("figures", "peers"):
    sys.path.insert(0, str(HERE.parent / name))

import common
import numpy as np
import vtu
from common import FOLDER, row, support
from pair_bodies import Grid, write

__all__ = [
    "along", "away", "common", "elastic", "grid", "held", "knots", "mesh", "mirrored", "pair", "row", "rubber", "run", "sector", "vtu",
]


def elastic(young, poisson=0.3):
    return {"model": "linear-elastic", "young_modulus": young, "poisson_ratio": poisson}


def rubber(shear=1.0, bulk=None):
    return {"model": "neo-hookean", "shear_modulus": shear} | ({"bulk_modulus": bulk} if bulk else {})


def grid(name, counts, where):
    return Grid(name, counts, where, np.random.default_rng(0))


def mirrored(body, name):
    """The image of a grid in y = 0."""
    image = grid(name, (1, 1), lambda s, t: (s, t))
    image.points = body.points * [1.0, -1.0]
    image.cells = body.cells[:, [0, 2, 1]]
    image.sides = {side: facets[:, ::-1] for side, facets in body.sides.items()}
    image.middles = {side: middles * [1.0, -1.0] for side, middles in body.middles.items()}
    return image


def mesh(name, *bodies, curved=False):
    path = FOLDER / f"{name}.msh"
    write(path, bodies, curved)
    return path


def pair(first, second, name="pair", **keys):
    return {"name": name, "between": [first, second]} | keys


def held(on, **axes):
    return support(on, on, **(axes or {"x": 0.0, "y": 0.0}))


def run(name, *sets, out=None, **keys):
    return common.solve(common.scene(name, **keys), *sets, out=out)


def away(value, exact):
    return abs(value / exact - 1)


def knots(first, even, length, growth=1.2):
    """Places of vertices on [0, length]: cells of size `first` up to `even`, then each larger by `growth`."""
    count = max(1, round(min(even, length) / first))
    if even >= length:
        return np.linspace(0.0, length, count + 1)
    places, size = [even * k / count for k in range(count + 1)], even / count
    while places[-1] < length:
        size *= growth
        places.append(places[-1] + size)
    if len(places) > count + 2 and places[-1] - length > 0.5 * size:
        places.pop()
    tail = np.array(places[count:])
    return np.concatenate([places[:count], even + (tail - even) * (length - even) / (tail[-1] - even)])


def along(places):
    """The map of [0, 1] that takes vertices of an even grid to `places`."""
    index = np.arange(len(places))
    return lambda s: np.interp(np.asarray(s) * index[-1], index, places)


def sector(name, radius, foot, cell, even, sense=1.0, hub=0.3):
    """A quarter of a ring about (0, foot + sense radius), from its foot (0, foot) on: sides NAME-skin, -hub, -axis."""
    angles = along(knots(cell / radius, even / radius, 0.5 * np.pi))
    depths = along(knots(cell, even, radius * (1 - hub)))

    def where(s, t):
        angle, r = angles(s), radius - depths(t)
        return r * np.sin(angle), foot + sense * (radius - r * np.cos(angle))

    counts = [len(knots(cell / radius, even / radius, 0.5 * np.pi)) - 1, len(knots(cell, even, radius * (1 - hub))) - 1]
    body = grid(name, counts, where)
    for old, new in (("y0", "skin"), ("y1", "hub"), ("x0", "axis")):
        body.sides[new], body.middles[new] = body.sides.pop(old), body.middles.pop(old)
    return body
