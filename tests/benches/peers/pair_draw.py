"""Random scenes of two and more soft bodies, each from its own seed: mesh and TOML text.

Kinds: flat blocks, wavy and tilted interfaces, blocks with a corner in the contact, rings in rings (shrink fits, and
pushed aside), rollers on blocks and on each other, closed boxes, stacks of three with a floating one, blocks under a
traction or a tool that contact alone holds, bushes on shafts about an axis; apart, tips led through a gap. Moduli 1:1
to 1:1e6 either way, Poisson ratios .3, .49 and .5, rubber, meshes finer and coarser, either side carrying where neither
is much stiffer; a press, then mostly a slide or a pull back.
"""
import math
from dataclasses import dataclass, field

import numpy as np

from pair_bodies import Grid


@dataclass
class Draft:
    """A scene under way."""

    random: np.random.Generator
    kind: str = ""
    bodies: list = field(default_factory=list)
    # (name, group, {axis: value})
    supports: list = field(default_factory=list)
    # (group, group)
    contacts: list = field(default_factory=list)
    # Of each step: {support: {axis: value}}
    steps: list = field(default_factory=list)
    obstacles: list = field(default_factory=list)
    travel: float = 0.0
    tractions: list = field(default_factory=list)
    probes: list = field(default_factory=list)
    revolved: bool = False
    curved: bool = False
    rubber: bool = False
    friction: list = field(default_factory=list)
    shears: dict = field(default_factory=dict)
    laws: dict = field(default_factory=dict)

    def hold(self, name, group, **values):
        self.supports.append((name, group, values))

    def add(self, name, counts, where, closed=False):
        jitter = float(self.random.choice([0.0, 0.12, 0.2]))
        body = Grid(name, counts, where, self.random, jitter, closed)
        self.bodies.append(body)
        return body

    def alike(self, pair):
        """Whether either side may carry."""
        shears = [self.shears[group.split("-")[0]] for group in pair]
        return max(shears) <= 3.0 * min(shears)

    def probe(self, body, place):
        self.probes.append(body.nearest(place))

    def between(self, low, high):
        return float(self.random.uniform(low, high))

    def count(self, low, high):
        return int(self.random.integers(low, high + 1))

    def press_and_slide(self, support, depth, way):
        """Pressed along -y, then moved along x, or back."""
        steps = [{support: {"x": 0.0, "y": -depth}}]
        rest = self.random.choice(["none", "slide", "back", "both"])
        if rest in ("slide", "both"):
            steps.append({support: {"x": way, "y": -depth}})
        if rest in ("back", "both"):
            steps.append({support: {"x": way if rest == "both" else 0.0, "y": -0.4 * depth}})
        self.steps = steps


def flat(it):
    """A block on a wider one."""
    width = it.between(0.5, 1.4)
    at, height = it.between(-0.2, 0.2), it.between(0.4, 1.0)
    it.add("lower", (it.count(3, 9), it.count(2, 6)), lambda s, t: (2.4 * s - 1.2, t - 1.0))
    it.add("upper", (it.count(2, 8), it.count(2, 5)), lambda s, t: (at + width * (s - 0.5), height * t))
    ends(it)
    it.press_and_slide("head", it.between(0.005, 0.08) * height, it.between(-0.15, 0.15))


def ends(it):
    """The lower body stands, the upper one is led, both pairs in contact."""
    it.hold("base", "lower-y0", x=0.0, y=0.0)
    it.hold("head", "upper-y1", x=0.0, y=0.0)
    it.contacts.append(("upper-y0", "lower-y1"))
    it.probe(it.bodies[0], (0.1, 0.0))
    it.probe(it.bodies[1], (0.1, 0.1))


def tilted(it):
    """Both turned by an angle, and the upper one by a little more."""
    flat(it)
    angle, more = it.between(-0.7, 0.7), it.between(-0.03, 0.03)
    lower, upper = it.bodies
    lower.turn(angle)
    upper.turn(angle + more)
    turn = rotation(angle)
    for step in it.steps:
        x, y = turn @ np.array([step["head"]["x"], step["head"]["y"]])
        step["head"] = {"x": round(x, 8), "y": round(y, 8)}
    it.probes = [turn @ np.array(probe) for probe in it.probes]
    it.probes = [body.nearest(probe) for body, probe in zip(it.bodies, it.probes)]


def rotation(angle):
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def wavy(it):
    """Two blocks that fit each other along waves, up to what straight edges miss."""
    waves, height, phase = it.between(1.0, 5.0), it.between(0.02, 0.1), it.between(0.0, 6.0)

    def wave(x):
        return height * np.cos(waves * x + phase)

    apart = it.between(0.0, 0.02)
    it.add("lower", (it.count(5, 12), it.count(2, 5)), lambda s, t: (2 * s - 1, t - 1 + t * wave(2 * s - 1)))

    def above(s, t):
        return t + apart + (1 - t) * wave(1.8 * s - 0.9)

    it.add("upper", (it.count(4, 12), it.count(2, 5)), lambda s, t: (1.8 * s - 0.9, above(s, t)))
    ends(it)
    it.press_and_slide("head", apart + it.between(0.01, 0.06), it.between(-0.1, 0.1))


def corner(it):
    """A block whose corners and sides may touch as well."""
    flat(it)
    it.bodies[1].join("skin", ["x0", "y0", "x1"])
    it.contacts = [("upper-skin", "lower-y1")]
    it.steps = [{"head": {"x": it.between(-0.05, 0.05), "y": -it.between(0.02, 0.12)}}]


def box(it):
    """Two blocks that fill a closed box, with a flat, wavy or kinked interface."""
    waves = it.between(1.0, 4.0)
    # Faces that turn by less than 30 degrees: corners of the surface that does not carry have no partner of their own.
    height = float(it.random.choice([0.0, 0.05, 0.1])) / waves

    def wave(x):
        return height * np.cos(waves * math.pi * x)

    it.add("lower", (it.count(5, 12), it.count(2, 5)), lambda s, t: (s, t - 1 + t * wave(s)))
    it.add("upper", (it.count(5, 12), it.count(2, 5)), lambda s, t: (s, t + (1 - t) * wave(s)))
    ends(it)
    for body in ("lower", "upper"):
        it.hold(f"{body}-left", f"{body}-x0", x=0.0)
        it.hold(f"{body}-right", f"{body}-x1", x=0.0)
    it.supports[0] = ("base", "lower-y0", {"y": 0.0})
    it.supports[1] = ("head", "upper-y1", {"y": 0.0})
    it.steps = [{"head": {"y": -it.between(0.005, 0.05)}}]
    it.laws["room"] = True


def annulus(inner, outer, centre=(0.0, 0.0), start=0.0):
    """Around, then outwards."""
    def where(s, t):
        angle, radius = -2 * math.pi * s + start, inner + (outer - inner) * t
        return centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    return where


def rings(it):
    """A ring on a core that is too large for it; faces turn by less than 30 degrees."""
    fit = it.between(0.001, 0.015)
    it.laws["room"] = True
    it.add("core", (it.count(13, 22), it.count(2, 3)), annulus(0.5, 1.0 + fit, start=it.between(0, 1)), True)
    it.add("ring", (it.count(13, 22), it.count(2, 3)), annulus(1.0, it.between(1.3, 1.8)), True)
    it.hold("axle", "core-y0", x=0.0, y=0.0)
    it.hold("seat", "ring-y1", x=0.0, y=0.0)
    it.contacts.append(("core-y1", "ring-y0"))
    it.probe(it.bodies[0], (0.8, 0.0))
    it.probe(it.bodies[1], (0.0, 1.2))
    it.steps = [{}]
    if it.random.random() < 0.6:
        it.steps.append({"axle": {"x": it.between(-0.03, 0.03), "y": it.between(-0.03, 0.03)}})


def journal(it):
    """A core that is smaller than its ring and pushed against it."""
    play = it.between(0.005, 0.05)
    it.add("core", (it.count(14, 24), it.count(2, 3)), annulus(0.5, 1.0 - play, start=it.between(0, 1)), True)
    it.add("ring", (it.count(14, 24), it.count(2, 3)), annulus(1.0, it.between(1.3, 1.8)), True)
    it.hold("axle", "core-y0", x=0.0, y=0.0)
    it.hold("seat", "ring-y1", x=0.0, y=0.0)
    it.contacts.append(("core-y1", "ring-y0"))
    it.probe(it.bodies[0], (0.0, -0.8))
    angle, way = it.between(-math.pi, math.pi), play + it.between(0.01, 0.06)
    it.steps = [{"axle": {"x": way * math.cos(angle), "y": way * math.sin(angle)}}]
    if it.random.random() < 0.5:
        angle += it.between(-0.3, 0.3)
        it.steps.append({"axle": {"x": way * math.cos(angle), "y": way * math.sin(angle)}})


def roller(it):
    """A roller on a block."""
    start = it.between(0, 1)
    it.add("lower", (it.count(6, 14), it.count(3, 6)), lambda s, t: (2.4 * s - 1.2, t - 1.0))
    it.add("upper", (it.count(16, 30), it.count(2, 4)), annulus(0.3, 0.8, (0.0, 0.8), start), True)
    it.hold("base", "lower-y0", x=0.0, y=0.0)
    it.hold("head", "upper-y0", x=0.0, y=0.0)
    it.contacts.append(("upper-y1", "lower-y1"))
    it.probe(it.bodies[0], (0.1, 0.0))
    it.press_and_slide("head", it.between(0.01, 0.1), it.between(-0.2, 0.2))


def rollers(it):
    """Two rollers."""
    radius = it.between(0.5, 1.2)
    it.add("lower", (it.count(16, 30), it.count(2, 4)), annulus(0.4, 1.0, (0.0, -1.0), it.between(0, 1)), True)
    own = annulus(0.4 * radius, radius, (0.0, radius), it.between(0, 1))
    it.add("upper", (it.count(16, 30), it.count(2, 4)), own, True)
    it.hold("base", "lower-y0", x=0.0, y=0.0)
    it.hold("head", "upper-y0", x=0.0, y=0.0)
    it.contacts.append(("upper-y1", "lower-y1"))
    it.probe(it.bodies[0], (0.0, 0.0))
    it.press_and_slide("head", it.between(0.01, 0.1) * radius, it.between(-0.1, 0.1))


def stack(it):
    """Three blocks, the middle one held by contact but for one vertical line."""
    height = it.between(0.3, 0.8)
    it.add("lower", (it.count(3, 8), it.count(2, 4)), lambda s, t: (2.0 * s - 1.0, t - 1.0))
    it.add("middle", (it.count(3, 8), it.count(2, 4)), lambda s, t: (1.6 * s - 0.8, height * t))
    it.add("upper", (it.count(2, 7), it.count(2, 4)), lambda s, t: (1.2 * s - 0.6, height + 0.6 * t))
    it.hold("base", "lower-y0", x=0.0, y=0.0)
    it.hold("head", "upper-y1", x=0.0, y=0.0)
    it.hold("guide", "middle-x0", x=0.0)
    it.contacts += [("middle-y0", "lower-y1"), ("upper-y0", "middle-y1")]
    it.probe(it.bodies[1], (0.1, 0.2))
    it.steps = [{"head": {"x": 0.0, "y": -it.between(0.01, 0.06)}}]
    if it.random.random() < 0.5:
        it.steps.append({"head": {"x": it.between(-0.1, 0.1), **{"y": it.steps[0]["head"]["y"]}}})


def floating(it):
    """A block that a traction presses on another one; nothing but contact holds it vertically."""
    flat(it)
    it.supports[1] = ("guide", "upper-x0", {"x": 0.0})
    load = it.between(0.005, 0.06)
    it.tractions.append(("upper-y1", (it.between(-0.1, 0.0) * load, -load)))
    it.steps = [{}]


def bush(it):
    """A bush on a shaft about the axis, radially too tight, or pushed along."""
    fit, low = it.between(-0.01, 0.02), it.between(-0.3, 0.1)
    it.add("shaft", (it.count(2, 3), it.count(4, 9)), lambda s, t: (0.5 + (0.5 + fit) * s, 2.0 * t - 0.7))
    it.add("bush", (it.count(2, 4), it.count(3, 8)), lambda s, t: (1.0 + 0.6 * s, low + 0.9 * t))
    it.hold("axle", "shaft-x0", x=0.0, y=0.0)
    it.hold("seat", "bush-x1", x=0.0, y=0.0)
    it.contacts.append(("bush-x0", "shaft-x1"))
    it.probe(it.bodies[1], (1.3, low + 0.5))
    it.steps = [{"seat": {"x": -max(it.between(0.0, 0.03), 0.01 - fit), "y": 0.0}}]
    if it.random.random() < 0.5:
        it.steps.append({"seat": {"x": it.steps[0]["seat"]["x"], "y": it.between(-0.1, 0.1)}})
    it.revolved = True


def tool(it):
    """Two blocks under a tool that comes down on the upper one, which contact alone holds vertically."""
    flat(it)
    it.supports[1] = ("guide", "upper-x0", {"x": 0.0})
    top = it.bodies[1].points[:, 1].max()
    if it.random.random() < 0.5:
        shape = f'{{ kind = "half-space", point = [0.0, {top:.8f}, 0.0], normal = [0.0, -1.0, 0.0] }}'
    else:
        radius = it.between(0.5, 2.0)
        centre = f"[{it.between(-0.1, 0.1):.8f}, {top + radius:.8f}, 0.0]"
        shape = f'{{ kind = "sphere", centre = {centre}, radius = {radius:.8f} }}'
    it.obstacles.append(("tool", "upper-y1", shape))
    it.steps = [{}]
    it.travel = -it.between(0.005, 0.06)


def wedge(it):
    """A tip, sharp or with a flat end, led through a gap into a block; its flanks turn by more than 30 degrees."""
    gap, steep, width = it.between(0.0, 0.1), it.between(0.6, 1.5), it.between(0.4, 0.9)
    columns = it.count(3, 8)
    half = 0.5 * width / columns * (columns % 2)

    def above(s, t):
        low = gap + steep * np.maximum(np.abs(width * (s - 0.5)) - half, 0.0)
        return low + t * (gap + steep * width - low)

    it.add("lower", (it.count(4, 14), it.count(2, 6)), lambda s, t: (2.4 * s - 1.2, t - 1.0))
    it.add("upper", (columns, it.count(2, 4)), lambda s, t: (width * (s - 0.5), above(s, t)))
    ends(it)
    it.steps = [{"head": {"x": it.between(-0.03, 0.03), "y": -gap - it.between(0.01, 0.08)}}]


KINDS = {kind.__name__: kind for kind in (
    flat, tilted, wavy, corner, box, rings, journal, roller, rollers, stack, floating, bush, tool,
)}
# Kinds that are drawn when named alone: families of before keep their scenes.
APART = {kind.__name__: kind for kind in (wedge,)}


# Bodies that begin inside each other, which `pair_friction` does not push apart, and tools beside.
TIGHT = ("rings", "bush", "tool")
# Kinds that may have meshes of second order.
ROUND = ("wavy", "box", "rings", "journal", "roller", "rollers")


def scene(seed, index, only=None, rough=False):
    """The draft of a number in the family of a seed, and its TOML text with MESH for the mesh's name."""
    random = np.random.default_rng([seed, index])
    kind = only or str(random.choice([kind for kind in KINDS if not (rough and kind in TIGHT)]))
    it = Draft(random, kind)
    (KINDS | APART)[kind](it)
    materials(it)
    it.curved = kind in ROUND and bool(it.random.random() < 0.5)
    if rough:
        it.friction = [friction(it) for _ in it.contacts]
    return it, toml(it)


def friction(it):
    """The line of a contact."""
    if it.random.random() < 0.9:
        return f"friction = {it.between(0.05, 0.6):.4f}"
    return f"tresca = {min(it.shears.values()) * it.between(0.002, 0.05):.6g}"


def materials(it):
    """Laws of all bodies: linear or rubber, moduli up to 1e6 apart."""
    it.rubber = it.revolved or bool(it.random.random() < 0.55)
    for number, body in enumerate(it.bodies):
        contrast = 0.0 if number else float(it.random.choice([0, 0, 0.3, 1, 2, 3, 4, 6]))
        shear = round(10.0 ** (contrast * it.random.choice([-1, 1])), 10)
        it.shears[body.name] = shear
        it.laws[body.name] = law(it, shear)


def law(it, shear):
    """Lines of a material."""
    if it.rubber and (it.random.random() < 0.85 or it.revolved):
        bulks = [1.0, 10.0, 100.0, 1e4] if it.laws.get("room") else [1.0, 10.0, 1e3, math.inf]
        bulk = float(it.random.choice(bulks))
        lines = [f"bulk_modulus = {bulk * shear:.10g}"] if bulk < math.inf else []
        if it.random.random() < 0.5:
            return ['model = "neo-hookean"', f"shear_modulus = {shear:.10g}", *lines]
        part = it.random.choice([0.1, 0.25])
        shares = [f"c10 = {0.5 * shear * (1 - part):.10g}", f"c01 = {0.5 * shear * part:.10g}"]
        return ['model = "mooney-rivlin"', *shares, *lines]
    ratio = float(it.random.choice([0.3, 0.49] if it.laws.get("room") else [0.3, 0.49, 0.5]))
    return ['model = "linear-elastic"', f"shear_modulus = {shear:.10g}", f"poisson_ratio = {ratio}"]


def toml(it):
    lines = ['mesh = "MESH"', f'kind = "{"axisymmetric" if it.revolved else "plane-strain"}"']
    for body in it.bodies:
        lines += ["", f"[material.{body.name}]", *it.laws[body.name]]
    for name, group, values in it.supports:
        lines += ["", "[[support]]", f'name = "{name}"', f'on = "{group}"', f"displacement = {table(values)}"]
    softest = min(it.shears.values())
    for group, value in it.tractions:
        x, y = (softest * component for component in value)
        lines += ["", "[[traction]]", f'on = "{group}"', f"value = [{x:.8g}, {y:.8g}, 0.0]"]
    for name, group, shape in it.obstacles:
        lines += ["", "[[obstacle]]", f'name = "{name}"', f'on = "{group}"', f"shape = {shape}"]
    for number, pair in enumerate(it.contacts):
        lines += ["", "[[contact]]", f'name = "pair-{number}"', f'between = ["{pair[0]}", "{pair[1]}"]']
        lines += it.friction[number : number + 1]
        side = it.count(0, 3)
        if side < 2 and it.alike(pair):
            lines.append(f'carries = "{pair[side]}"')
    for step in it.steps:
        lines += ["", "[[step]]", f"increments = {it.count(1, 4)}"]
        lines += [f"support.{name} = {{ displacement = {table(values)} }}" for name, values in step.items()]
        lines += [f"obstacle.{name} = {{ translation = [0.0, {it.travel:.8f}, 0.0] }}" for name, _, _ in it.obstacles]
    for number, (x, y) in enumerate(it.probes):
        lines += ["", "[[probe]]", f'name = "probe-{number}"', f"point = [{x:.8f}, {y:.8f}, 0.0]"]
    return "\n".join([*lines, "", "[solver]", "tolerance = 1e-11", ""])


def table(values):
    return "{ " + ", ".join(f"{axis} = {value:.8f}" for axis, value in values.items()) + " }"
