"""More kinds of random scenes: rings about an axis, two materials, up to three tools, lips bent over, rough lids.

K / mu runs from 2 to infinity here, that of the second material too. What each kind may ask for is bounded as in
`family_scenes`: closed bodies keep room, tools go no deeper than a part of what gives way below them.
"""
import math
from dataclasses import dataclass, field

import numpy as np

import family_scenes
from family_mesh import AXES, Box
from family_scenes import Draft, floor, hold_against_sliding, indenter, lid, wall

INCREMENTS = (1, 2, 4, 8)


@dataclass
class More(Draft):
    """A draft with what the new kinds add; `moved` holds for a second step how far tools go in it."""

    revolved: bool = False
    rubber: bool = False
    contrast: float = 1.0
    other_bulk: float = math.inf
    friction: dict = field(default_factory=dict)
    linear_space: bool = False
    moved: dict = field(default_factory=dict)


def scene(seed, index, only=None):
    """The draft of a number in the family of a seed, of kind `only` if named, and its TOML text but for the mesh's
    name."""
    # A third word keeps these draws apart from those of the old kinds.
    random = np.random.default_rng([seed, index, 1])
    kind = only or str(random.choice(list(KINDS)))
    it = (KINDS | APART)[kind](random)
    it.kind = kind
    return it, toml(it)


def number(random, low, high, digits=3):
    return round(float(random.uniform(low, high)), digits)


def bulk(random):
    return math.inf if random.random() < 0.3 else float(f"{10.0 ** random.uniform(math.log10(2.0), 6.0):.3g}")


def draft(random, box, squeeze=None):
    squeeze = squeeze or round(float(np.exp(random.uniform(np.log(0.01), np.log(0.15)))), 4)
    return More(random, box, {}, [], bulk(random), squeeze, "")


def push(it, name, side, shape, travel):
    it.obstacles.append((name, side, shape, travel))


def plane(point, normal):
    return {"kind": "half-space", "point": [*point, 0.0, 0.0][:3], "normal": [*normal, 0.0, 0.0][:3]}


def ring(random):
    """A box section away from the axis, about a shaft or in a sleeve, below a lid or a round rim."""
    inner = number(random, 0.2, 1.0) if random.random() < 0.5 else number(random, 1.0, 5.0)
    width, count = number(random, 0.4, 2.0), int(random.integers(3, 13))
    jitter = float(random.choice([0.0, 0.15]))
    it = draft(random, Box([width, 1.0], [max(2, round(count * width)), count], jitter, False, random))
    it.box.place(lambda points: points + [inner, 0.0])
    it.revolved = it.rubber = True
    it.supports["y0"] = "xy" if random.random() < 0.5 else "y"
    room = max(0.0, about_shaft(it, inner) + in_sleeve(it, inner + width))
    full = room / (math.pi * width * (2.0 * inner + width))
    if len(it.obstacles) + len(it.supports) > 2 and it.bulk > 100.0:
        # Nearly full at most where a sleeve and a shaft leave no way out.
        it.squeeze = round(min(it.squeeze, 0.9 * full), 5) or 0.001
    if random.random() < 0.3:
        return round_rim(it, inner, width)
    push(it, "lid", "y1", plane([0.0, 1.0], [0.0, -1.0]), [0.0, -it.squeeze, 0.0])
    return it


def about_shaft(it, inner):
    """Held by a shaft, on one that widens, or free; the room there."""
    draw = it.random.random()
    if draw < 0.3:
        it.supports["x0"] = "x"
        return 0.0
    if draw < 0.6:
        # A bonded base keeps its rim: the shaft widens less there.
        most = (0.04 if "x" in it.supports["y0"] else 0.15) * min(inner, 1.0)
        wider = round(number(it.random, 0.1, 1.0) * most, 5)
        push(it, "shaft", "x0", plane([inner], [1.0]), [wider, 0.0, 0.0])
        return math.pi * (inner**2 - (inner + wider) ** 2)
    return math.pi * (inner**2 - (0.7 * inner) ** 2)


def in_sleeve(it, outer):
    """A sleeve that is not touched at first, or a free side; the room there."""
    if it.random.random() < 0.5:
        return math.pi * outer**2
    room = number(it.random, 0.02, 0.2)
    push(it, "sleeve", "x1", plane([outer + room], [-1.0]), [0.0, 0.0, 0.0])
    return math.pi * ((outer + room) ** 2 - outer**2)


def round_rim(it, inner, width):
    """A torus pressed in from above."""
    radius = number(it.random, 0.4, 1.0)
    middle = inner + number(it.random, 0.35, 0.65) * width
    shape = {
        "kind": "torus", "centre": [0.0, 1.0 + radius, 0.0], "axis": [0.0, 1.0, 0.0],
        "radius": max(middle, radius + 0.1), "tube_radius": radius,
    }
    it.squeeze = min(it.squeeze, 0.1)
    push(it, "rim", "y1", shape, [0.0, -it.squeeze, 0.0])
    return it


def overfull(random):
    """A ring or a strip in a groove on rollers that a lid fills, then presses against K to at most 20 moduli."""
    is_ring = random.random() < 0.6
    inner, width, count = number(random, 0.2, 5.0), number(random, 0.4, 2.0), int(random.integers(2, 13))
    jitter = float(random.choice([0.0, 0.15]))
    it = draft(random, Box([width, 1.0], [max(1, round(count * width)), count], jitter, False, random))
    it.bulk = float(f"{10.0 ** random.uniform(2.0, 5.0):.3g}")
    it.rubber = it.revolved = is_ring
    it.supports["y0"], it.supports["x0"] = ("xy" if random.random() < 0.3 else "y"), "x"
    it.box.place(lambda points: points + [inner if is_ring else 0.0, 0.0])
    room = number(random, 0.01, 0.1)
    start = (inner if is_ring else 0.0) + width
    push(it, "sleeve", "x1", plane([start + room], [-1.0]), [0.0, 0.0, 0.0])
    more = ((start + room) ** 2 - inner**2) / (start**2 - inner**2) if is_ring else 1.0 + room / width
    it.squeeze = round(1.0 - 1.0 / more + min(number(random, 0.0, 0.03, 4), 20.0 / it.bulk), 5)
    push(it, "lid", "y1", plane([0.0, 1.0], [0.0, -1.0]), [0.0, -it.squeeze, 0.0])
    return it


def layers(random):
    """Two materials of a contrast up to 1e4, one above or beside the other, under a lid or a round tool."""
    if random.random() < 0.3:
        it = widened(indenter(random))
    else:
        it = draft(random, family_scenes.box(random, flat=3.0))
        floor(it)
        hold_against_sliding(it)
        tilt = 0.5 * family_scenes.tilt(it)
        lid(it, it.squeeze, tilt=tilt)
    axis = int(random.choice([0, it.dim - 1, it.dim - 1]))
    count = int(it.box.counts[axis])
    line = int(random.integers(1, count))
    it.box.split(axis, line)
    it.contrast = float(f"{10.0 ** random.uniform(0.0, 4.0):.3g}")
    it.other_bulk = it.bulk if random.random() < 0.5 else bulk(random)
    is_beyond_stiff = random.random() < 0.5
    if not is_beyond_stiff:
        it.contrast = 1.0 / it.contrast
    if axis == it.dim - 1:
        # What is soft takes all of the squeeze.
        soft = (line if is_beyond_stiff else count - line) / count
        shallower(it, 0.2 * soft)
    return it


def widened(it):
    """An old draft with K / mu and fields of the new ones."""
    return More(it.random, it.box, it.supports, it.obstacles, bulk(it.random), it.squeeze, it.kind)


def shallower(it, most):
    """Tools that go no further than `most`."""
    if it.squeeze > most:
        part, it.squeeze = most / it.squeeze, round(most, 5)
        it.obstacles = [(n, s, shape, [part * x for x in travel]) for n, s, shape, travel in it.obstacles]


def tools(random):
    """A lid, a cylinder and a wall at once, on sides of their own or the first two on one."""
    it = draft(random, family_scenes.box(random, halves=True, flat=3.0))
    is_walled = random.random() < 0.7
    if is_walled and it.bulk > 100.0:
        # A wall may press where the side across is free: the body has a way out.
        it.supports[f"{AXES[it.dim - 1]}0"] = AXES[: it.dim]
    else:
        floor(it)
        hold_against_sliding(it)
    width, up = float(it.box.sizes[0]), it.dim - 1
    down = lambda depth: [0.0] * up + [-depth] + [0.0] * (2 - up)
    is_shared = random.random() < 0.3
    top = [it.top + "a", it.top + "b"]
    lid(it, it.squeeze, top if is_shared else top[0])
    size = width / it.box.counts[0]
    radius = round(float(max(random.uniform(0.5, 2.0), 3.0 * size)), 3)
    depth = round(min(it.squeeze + number(random, 0.02, 0.08), 0.15), 4)
    point = [0.0, 0.0, 0.0]
    point[0] = number(random, 0.6, 0.9) * width
    point[up] = round(it.height + radius, 6)
    axis = [0.0, 0.0, 1.0] if it.dim == 2 else [0.0, 1.0, 0.0]
    shape = {"kind": "cylinder", "point": point, "axis": axis, "radius": radius}
    push(it, "roll", top if is_shared else top[1], shape, down(depth))
    if is_walled:
        wall(it, "x1", number(random, 0.0, 0.1))
        name, side, shape, _ = it.obstacles.pop()
        push(it, name, side, shape, [-number(random, 0.0, 0.1), 0.0, 0.0])
    return it


def lip(random):
    """A tapered section that leans, bonded below, bent by a wall or a cylinder from the side it leans to."""
    is_solid = random.random() < 0.2
    width, taper = number(random, 0.15, 0.5), number(random, 0.0, 0.6)
    lean = round(0.5 * taper * width + number(random, 0.05, 0.4), 4)
    across, along = int(random.integers(1, 5)), int(random.integers(4, 7 if is_solid else 17))
    if is_solid:
        box = Box([width, 0.5, 1.0], [min(across, 2), 2, along], 0.0, False, random)
    else:
        box = Box([width, 1.0], [across, along], 0.0, False, random)
    it = draft(random, box)
    it.rubber = random.random() < 0.85
    up = it.dim - 1
    it.supports[f"{AXES[up]}0"] = AXES[: it.dim]
    away = 0.0
    if not is_solid and it.rubber and random.random() < 0.3:
        it.revolved, away = True, number(random, 0.5, 3.0)
    half = 0.5 * width

    def leaning(points):
        moved = points.copy()
        moved[:, 0] = away + half + lean * points[:, up] + (points[:, 0] - half) * (1.0 - taper * points[:, up])
        return moved

    box.place(leaning)
    it.squeeze = round(number(random, 0.02, 0.9) * (lean if it.rubber else 0.1), 4)
    bend(it, away + width, lean - half * taper)
    return it


def bend(it, start, slope):
    """The tool beside the leaning face x = start + slope * height."""
    up, travel = it.dim - 1, [-it.squeeze, 0.0, 0.0]
    if it.random.random() < 0.5 or it.revolved:
        push(it, "wall", "x1", plane([start + slope], [-1.0]), travel)
        return
    height, radius = number(it.random, 0.6, 0.9), number(it.random, 0.3, 1.0)
    size = math.hypot(1.0, slope)
    point, axis = [0.0, 0.0, 0.0], [0.0, 0.0, 1.0] if it.dim == 2 else [0.0, 1.0, 0.0]
    point[0] = round(start + slope * height + radius / size, 8)
    point[up] = round(height - radius * slope / size, 8)
    push(it, "roll", "x1", {"kind": "cylinder", "point": point, "axis": axis, "radius": radius}, travel)


def rough_lid(random):
    """A rough lid pressed and dragged, in the linear space: what `saddle_friction` solves."""
    it = draft(random, family_scenes.box(random, flat=3.0))
    it.squeeze, it.rubber, it.linear_space = min(it.squeeze, 0.08), random.random() < 0.8, True
    it.supports[f"{AXES[it.dim - 1]}0"] = AXES[: it.dim]
    lid(it, it.squeeze, tilt=0.5 * family_scenes.tilt(it))
    rough(it)
    along = [number(random, 0.02, 0.15), 0.0 if it.dim == 2 else number(random, -0.05, 0.05)]
    travel = it.obstacles[0][3]
    it.moved["lid"] = [along[0], travel[1] if it.dim == 2 else along[1], travel[2]]
    return it


def rough_tools(random):
    """Several tools, or a lip and its wall, with friction."""
    it = tools(random) if random.random() < 0.5 else lip(random)
    if it.dim == 3 or not it.rubber:
        it.squeeze = min(it.squeeze, 0.1)
    rough(it)
    return it


def rough(it):
    it.friction = {name: number(it.random, 0.05, 0.9, 2) for name, *_ in it.obstacles}


def bricks(random):
    """A lid or a ball on a block of long or flat cells, one material or layers."""
    sizes = [number(random, 0.5, 2.0), number(random, 0.5, 1.5), 1.0]
    counts = [int(random.integers(1, 7)) for _ in range(3)]
    sizes, counts = (sizes, counts) if random.random() < 0.7 else (sizes[::2], [2 * n for n in counts[::2]])
    it = draft(random, Box(sizes, counts, float(random.choice([0.0, 0.15])), False, random))
    up, axis = it.dim - 1, int(random.integers(0, it.dim))
    floor(it)
    hold_against_sliding(it)
    if counts[axis] > 1 and random.random() < 0.5:
        line = int(random.integers(1, counts[axis]))
        it.box.split(axis, line)
        it.contrast, it.other_bulk = float(f"{10.0 ** random.uniform(-4.0, 4.0):.3g}"), it.bulk
        it.squeeze = min(it.squeeze, 0.1 * min(line, counts[axis] - line) / counts[axis])
    it.squeeze = round(min(it.squeeze, 0.3 / counts[up]), 5)
    lid(it, it.squeeze)
    return it


KINDS = {
    "ring": ring, "overfull": overfull, "layers": layers, "tools": tools, "lip": lip, "rough-lid": rough_lid,
    "rough-tools": rough_tools,
}
# Only by name, so that the draws of the others stay.
APART = {"bricks": bricks}


def laws(it):
    """Lines of each material; shear modulus one of the first, the contrast of the second."""
    draw = it.random.random()
    is_linear = not it.rubber and draw < (0.4 if it.squeeze < 0.06 else 0.15)
    model = "linear-elastic" if is_linear else "neo-hookean" if draw < 0.75 else "mooney-rivlin"
    values = {"body": (1.0, it.bulk), "other": (it.contrast, it.other_bulk)}
    lines = []
    for name in it.box.regions:
        lines += ["", f"[material.{name}]", f'model = "{model}"', *constants(model, *values[name])]
    return lines


def constants(model, shear, ratio):
    if model == "linear-elastic":
        poisson = 0.5 if math.isinf(ratio) else (3.0 * ratio - 2.0) / (2.0 * (3.0 * ratio + 1.0))
        return [f"shear_modulus = {shear!r}", f"poisson_ratio = {poisson!r}"]
    law = [f"c10 = {0.4 * shear!r}", f"c01 = {0.1 * shear!r}"]
    law = [f"shear_modulus = {shear!r}"] if model == "neo-hookean" else law
    return law + ([] if math.isinf(ratio) else [f"bulk_modulus = {ratio * shear!r}"])


def toml(it):
    title = f"# {it.kind}, squeeze {it.squeeze:g}, K / mu = {it.bulk:g}"
    title += f", contrast {it.contrast:g}, other K / mu = {it.other_bulk:g}" if len(it.box.regions) > 1 else ""
    lines = [title, 'mesh = "MESH"'] + (['kind = "axisymmetric"'] if it.revolved else [])
    lines += laws(it) + family_scenes.support_lines(it)
    for line in family_scenes.obstacle_lines(it):
        lines.append(line)
        if line.startswith("name = ") and line[8:-1] in it.friction:
            lines.append(f"friction = {it.friction[line[8:-1]]}")
    lines += ["", "[solver]", 'contact_space = "linear"'] if it.linear_space else []
    lines += ["", "[[step]]", f"increments = {int(it.random.choice(INCREMENTS))}", *family_scenes.travel_lines(it)]
    if it.moved:
        lines += ["", "[[step]]", f"increments = {int(it.random.choice(INCREMENTS))}"]
        lines += [f"obstacle.{n} = {{ translation = {family_scenes.value_of(t)} }}" for n, t in it.moved.items()]
    return "\n".join(lines) + "\n"
