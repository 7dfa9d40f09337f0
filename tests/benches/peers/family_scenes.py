"""Random scenes of frictionless contact that have a physically sensible answer, each from its own seed.

No closed incompressible body is asked to lose volume: where K is infinite one side stays free, or a groove keeps
room; curved obstacles obey h < 4 mu R / p with p of the order of the modulus. The body fills [0, size], mu = 1.
"""
import math
from dataclasses import dataclass

import numpy as np

from family_mesh import AXES, Box

BULK = (1.0, 10.0, 100.0, 1e3, 1e4, 1e6, math.inf)
INCREMENTS = (1, 1, 2, 4, 8, 20)


@dataclass
class Draft:
    """A scene under way: mesh, supports {side: axes}, obstacles [(name, side, shape, translation)]."""

    random: np.random.Generator
    box: Box
    supports: dict
    obstacles: list
    bulk: float
    squeeze: float
    kind: str

    @property
    def dim(self):
        return self.box.dim

    @property
    def top(self):
        return f"{AXES[self.dim - 1]}1"

    @property
    def height(self):
        return float(self.box.sizes[-1])


def scene(seed, index):
    """The draft of a number in the family of a seed, and its TOML text but for the mesh's name."""
    random = np.random.default_rng([seed, index])
    kind = random.choice(list(KINDS))
    draft = KINDS[kind](random)
    draft.kind = str(kind)
    return draft, toml(draft, index)


def box(random, halves=False, flat=1.0):
    """A box, `flat` times as wide as high at most."""
    dim = 2 if random.random() < 0.65 else 3
    most = 16 if dim == 2 else 5
    width = round(float(random.uniform(1.0, max(flat, 1.2))), 2)
    count = int(random.integers(2, most + 1))
    across = max(2, round(count / width))
    across_x = count + count % 2 if halves else count
    counts = [across_x, across] if dim == 2 else [min(across_x, 4 if halves else 5), min(count, 5), min(across, 5)]
    sizes = [width, 1.0] if dim == 2 else [width, round(float(random.uniform(0.8, 1.2)), 2), 1.0]
    jitter = float(random.choice([0.0, 0.0, 0.15]))
    return Box(sizes, counts, jitter, halves, random)


def draft(random, body, bulks=BULK):
    squeeze = round(float(np.exp(random.uniform(np.log(0.01), np.log(0.2)))), 4)
    return Draft(random, body, {}, [], float(random.choice(bulks)), squeeze, "")


def sides(dim):
    return [f"{AXES[axis]}{end}" for axis in range(dim - 1) for end in (0, 1)]


def lid(it, depth, side=None, name="lid", tilt=0.0, at=None):
    """A half-space over a top side that comes down by `depth`."""
    up = it.dim - 1
    normal = [0.0, 0.0, 0.0]
    normal[0], normal[up] = math.sin(tilt), -math.cos(tilt)
    point = [0.0, 0.0, 0.0]
    point[0] = at if at is not None else 0.5 * float(it.box.sizes[0])
    # The lowest corner of a tilted lid meets the body first: its start touches there.
    point[up] = it.height + abs(math.tan(tilt)) * float(it.box.sizes[0]) * 0.5
    travel = [0.0, 0.0, 0.0]
    travel[up] = -depth
    shape = {"kind": "half-space", "point": point, "normal": normal}
    it.obstacles.append((name, side or it.top, shape, travel))


def floor(it):
    """Held or sliding below."""
    up = AXES[it.dim - 1]
    if it.random.random() < 0.6:
        it.supports[f"{up}0"] = AXES[: it.dim]
    else:
        it.supports[f"{up}0"] = up


def hold_against_sliding(it):
    """Rollers on a lower side of each axis along which nothing else holds."""
    for axis in range(it.dim - 1):
        if not any(AXES[axis] in held for held in it.supports.values()):
            it.supports[f"{AXES[axis]}0"] = AXES[axis]


def tilt(it):
    return 0.0 if it.random.random() < 0.6 else round(float(it.random.uniform(-0.1, 0.1)), 4)


def pressed(random):
    """A lid on a box with free sides, some of them rollers."""
    it = draft(random, box(random, flat=4.0))
    floor(it)
    if random.random() < 0.3:
        it.supports["x0"] = "x"
    if it.dim == 3 and random.random() < 0.3:
        it.supports["y0"] = "y"
    hold_against_sliding(it)
    lid(it, it.squeeze, tilt=tilt(it))
    return it


def far_wall(random):
    """The same beside a wall that is never touched."""
    it = pressed(random)
    width = float(it.box.sizes[0])
    shape = {"kind": "half-space", "point": [9.0 * width, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0]}
    it.obstacles.append(("far", "x1", shape, [0.0, 0.0, 0.0]))
    return it


def clamped_sides(random):
    """A lid on a body whose sides are clamped or rollers, closed but for a finite K or one free side."""
    it = draft(random, box(random, flat=2.0))
    it.supports[f"{AXES[it.dim - 1]}0"] = AXES[: it.dim]
    closed = sides(it.dim)
    if math.isinf(it.bulk):
        closed.remove(random.choice(closed))
    clamped = random.random() < 0.4
    for side in closed:
        it.supports[side] = AXES[: it.dim] if clamped else side[0]
    if clamped:
        it.squeeze = below_a_rim(it)
    lid(it, it.squeeze, tilt=0.3 * tilt(it))
    return it


def five_clamped(random):
    """All faces but the top clamped, and a lid pressed below its held rim."""
    it = draft(random, box(random), BULK[:-1])
    for side in sides(it.dim) + [f"{AXES[it.dim - 1]}0"]:
        it.supports[side] = AXES[: it.dim]
    it.squeeze = below_a_rim(it)
    lid(it, it.squeeze)
    return it


def below_a_rim(it):
    """A squeeze under a clamped rim: the pressure, some K s, stays below 50 moduli, or the rim tears off."""
    return float(f"{min(it.squeeze / 5.0, 50.0 / it.bulk if math.isfinite(it.bulk) else 1.0):.4g}")


def roller_box(random):
    """Rollers on all sides but the top: homogeneous, whatever K."""
    it = draft(random, box(random), BULK[:-1])
    for side in sides(it.dim) + [f"{AXES[it.dim - 1]}0"]:
        it.supports[side] = side[0]
    lid(it, it.squeeze)
    return it


def groove(random):
    """A lid presses a body against a wall it does not touch at first."""
    it = draft(random, box(random, flat=1.5))
    floor(it)
    if it.dim == 3:
        it.supports["y0"] = it.supports["y1"] = "y"
    room = round(float(random.uniform(0.02, 0.25)), 3) * float(it.box.sizes[0])
    if random.random() < 0.5:
        wall(it, "x1", room)
        wall(it, "x0", 0.5 * room)
        room = 1.5 * room
        it.supports.setdefault(f"{AXES[it.dim - 1]}0", "")
        if "x" not in it.supports[f"{AXES[it.dim - 1]}0"]:
            it.supports[f"{AXES[it.dim - 1]}0"] = AXES[: it.dim]
    else:
        wall(it, "x1", room)
        it.supports["x0"] = "x"
    full = room / (room + float(it.box.sizes[0]))
    # Nearly full where K is infinite or large, never beyond.
    if it.bulk > 100.0:
        it.squeeze = round(min(it.squeeze, 0.9 * full), 5)
    lid(it, it.squeeze)
    return it


def wall(it, side, room):
    inwards = 1.0 if side[1] == "0" else -1.0
    place = -room if side[1] == "0" else float(it.box.sizes[0]) + room
    shape = {"kind": "half-space", "point": [place, 0.0, 0.0], "normal": [inwards, 0.0, 0.0]}
    it.obstacles.append((f"wall-{side}", side, shape, [0.0, 0.0, 0.0]))


def halves(random):
    """Two obstacles on the halves of one flat side."""
    it = draft(random, box(random, halves=True, flat=3.0))
    floor(it)
    hold_against_sliding(it)
    difference = round(float(random.uniform(0.0, 0.3)), 3) * it.squeeze
    lid(it, it.squeeze, it.top + "a", "left")
    if random.random() < 0.5:
        lid(it, it.squeeze - difference, it.top + "b", "right")
    else:
        lid(it, it.squeeze - difference, it.top + "b", "right", 0.3 * tilt(it))
    return it


def indenter(random):
    """A sphere or a cylinder pressed in."""
    it = draft(random, box(random, flat=2.0))
    floor(it)
    hold_against_sliding(it)
    size = (it.box.sizes / it.box.counts).max()
    radius = round(float(max(random.uniform(0.6, 3.0), 3.0 * size)), 3)
    # Deep enough to reach the first mean over a function, not past a tenth of the height.
    it.squeeze = round(float(min(max(it.squeeze, 0.3 * size**2 / radius), 0.12)), 4)
    up = it.dim - 1
    centre = [round(float(x) * random.uniform(0.3, 0.7), 3) for x in it.box.sizes] + [0.0]
    centre = centre[:3]
    centre[up] = round(it.height + radius, 6)
    travel = [0.0, 0.0, 0.0]
    travel[up] = -it.squeeze
    if it.dim == 3 and random.random() < 0.6:
        shape = {"kind": "sphere", "centre": centre, "radius": radius}
    else:
        axis = [0.0, 0.0, 1.0] if it.dim == 2 else [0.0, 1.0, 0.0]
        shape = {"kind": "cylinder", "point": centre, "axis": axis, "radius": radius}
    it.obstacles.append(("tool", it.top, shape, travel))
    return it


KINDS = {
    "pressed": pressed, "far-wall": far_wall, "clamped-sides": clamped_sides, "five-clamped": five_clamped,
    "roller-box": roller_box, "groove": groove, "halves": halves, "indenter": indenter,
}


def material(it):
    """Linear below 6 % squeeze at times, else neo-Hookean or Mooney-Rivlin, of shear modulus one."""
    draw = it.random.random()
    if draw < (0.4 if it.squeeze < 0.06 else 0.15):
        k = it.bulk
        ratio = 0.5 if math.isinf(k) else (3.0 * k - 2.0) / (2.0 * (3.0 * k + 1.0))
        return ['model = "linear-elastic"', "shear_modulus = 1.0", f"poisson_ratio = {ratio!r}"], False
    bulk = [] if math.isinf(it.bulk) else [f"bulk_modulus = {it.bulk!r}"]
    if draw < 0.75:
        return ['model = "neo-hookean"', "shear_modulus = 1.0"] + bulk, True
    return ['model = "mooney-rivlin"', "c10 = 0.4", "c01 = 0.1"] + bulk, True


def toml(it, index):
    law, is_rubber = material(it)
    increments = int(it.random.choice(INCREMENTS))
    lines = [f"# {it.kind}, squeeze {it.squeeze:g}, K / mu = {it.bulk:g}", 'mesh = "MESH"', "", "[material.body]", *law]
    lines += support_lines(it) + obstacle_lines(it) + ["", "[[step]]", f"increments = {increments}"]
    return "\n".join(lines + travel_lines(it)) + "\n"


def support_lines(it):
    lines = []
    for side, axes in it.supports.items():
        held = ", ".join(f"{axis} = 0.0" for axis in axes)
        lines += ["", "[[support]]", f'name = "{side}"', f'on = "{side}"', f"displacement = {{ {held} }}"]
    return lines


def obstacle_lines(it):
    lines = []
    for name, side, shape, _ in it.obstacles:
        shape = ", ".join(f"{key} = {value_of(value)}" for key, value in shape.items())
        lines += ["", "[[obstacle]]", f'name = "{name}"', f"on = {value_of(side)}", f"shape = {{ {shape} }}"]
    return lines


def travel_lines(it):
    """Where the tools go that move."""
    moving = [(name, travel) for name, _, _, travel in it.obstacles if any(travel)]
    return [f"obstacle.{name} = {{ translation = {value_of(travel)} }}" for name, travel in moving]


def value_of(value):
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return "[" + ", ".join(map(value_of, value)) + "]"
    return repr(float(value))
