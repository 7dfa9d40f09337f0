#!/usr/bin/env python3
"""What a pair costs beside the same body under a rigid tool at equal tolerance: programs, applications of the
preconditioner, seconds; contrasts of moduli 1 to 1e6, linear and rubber, bodies that contacts alone hold.

A half disc presses a block, rubber slides. Tools are a rigid cylinder in its place and a rigid plane in that of the
block, the one that takes more counts: some meshes take more than others. Seconds are those of fresh processes by turns,
the block refined to as many unknowns as the pair has.
"""
from shared import common, elastic, grid, held, mesh, pair, row, rubber, run
from sliding import half_disc

FLOOR = {"kind": "half-space", "point": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0]}
CONTRASTS = (1.0, 1e2, 1e4, 1e6)


def steps(press, slide, top):
    """Presses, then slides in four increments."""
    ways = [(1, 0.0)] + ([(4, slide)] if slide else [])
    return [{"increments": n, "support": {top: {"displacement": {"x": x, "y": -press}}}} for n, x in ways]


def block(cell):
    count = round(2.0 / cell / 1.37) * 2
    return grid("block", (count, max(4, count // 4)), lambda s, t: (4 * s - 2.0, t - 1.0))


def tool(law, cell, press, slide):
    """A rigid cylinder on the block."""
    keys = {"mesh": mesh(f"tool-{cell:.4f}", block(cell), curved=True), "material": {"block": law}, "support": [held("block-y0")]}
    shape = {"kind": "cylinder", "point": [0.0, 1.0, 0.0], "axis": [0.0, 0.0, 1.0], "radius": 1.0}
    ways = [(1, 0.0)] + ([(4, slide)] if slide else [])
    keys["step"] = [{"increments": n, "obstacle": {"pair": {"translation": [x, -press, 0.0]}}} for n, x in ways]
    return lambda: run(f"tool-{cell:.4f}", **keys, obstacle=[{"name": "pair", "on": "block-y1", "shape": shape}], solver=options(law))


def plate(law, cell, press, slide):
    """The half disc on a rigid plane."""
    disc = half_disc("disc", 1.0, cell, 0.6)
    keys = {"mesh": mesh(f"plate-{cell:.4f}", disc, curved=True), "material": {"disc": law}, "support": [held("disc-top")]}
    keys["obstacle"] = [{"name": "pair", "on": "disc-skin", "shape": FLOOR}]
    return lambda: run(f"plate-{cell:.4f}", **keys, step=steps(press, slide, "disc-top"), solver=options(law))


def options(law):
    return {"error_estimate": "off", "response": "iterative"} if law["model"] == "linear-elastic" else {}


def both(laws, cell, press, slide, moved="disc"):
    """The half disc on the block; the one that is moved."""
    disc = half_disc("disc", 1.0, cell, 0.6)
    keys = {"mesh": mesh(f"both-{cell:.4f}", disc, block(cell), curved=True), "material": dict(zip(("disc", "block"), laws))}
    keys["support"] = [held("disc-top"), held("block-y0")]
    way = steps(press, slide, "disc-top") if moved == "disc" else steps(-press, -slide, "block-y0")
    return lambda: run(f"both-{cell:.4f}", **keys, contact=[pair("disc-skin", "block-y1")], step=way, solver=options(laws[0]))


def floating(laws, cell, press):
    """A block that lies on another one, pressed by a traction: contact alone holds it."""
    count = round(2.0 / cell)
    low = grid("low", (count, count // 4), lambda s, t: (4 * s - 2.0, t - 1.0))
    middle = grid("middle", (round(0.73 * count), count // 4), lambda s, t: (3 * s - 1.5, 0.75 * t))
    keys = {"mesh": mesh("floating", low, middle), "material": {"low": laws[1], "middle": laws[0]}, "support": [held("low-y0")]}
    keys["traction"] = [{"on": "middle-y1", "value": [0.0, -press, 0.0]}]
    return lambda: run("floating", **keys, contact=[pair("middle-y0", "low-y1")], solver=options(laws[0]))


def pressed(law, cell, press):
    """The middle block of `floating`, its foot on a plane, held across in the middle."""
    count = round(2.0 / cell)
    middle = grid("middle", (round(0.73 * count), count // 4), lambda s, t: (3 * s - 1.5, 0.75 * t))
    keys = {"mesh": mesh("pressed", middle), "material": {"middle": law}, "support": [held("middle-x0", x=0.0)]}
    keys["traction"] = [{"on": "middle-y1", "value": [0.0, -press, 0.0]}]
    obstacle = {"name": "pair", "on": "middle-y0", "shape": FLOOR}
    return lambda: run("pressed", **keys, obstacle=[obstacle], solver=options(law))


def tell(label, rigid, soft, most):
    """Of several rigid scenes the one that takes most in each increment counts."""
    found, beside = soft(), [scene() for scene in rigid]
    for scene in (found, *beside):
        if not scene.converged:
            return row(label, "converged", scene.end, False)
    counts = [max(each) for each in zip(*(scene.applications for scene in beside), strict=True)]
    own, other = sum(found.applications), sum(counts)
    words = f"{own} / {other} = {own / other:.2f} ({found.applications}, {counts})"
    row(f"{label}: applications", f"<= {most} x", words, own <= most * other)
    programs = [s["sqp_iterations"] for s in found.steps]
    met = programs[0] <= 6 and max(programs[1:], default=0) <= 4
    row(f"{label}: programs", "<= 6 to press, <= 4 to slide", f"{programs}", met)
    return None


def timed(label, law, cell, press, slide):
    """Seconds of equal unknowns."""
    soft = both((law, law), cell, press, slide)
    wanted, finer = unknowns(soft()), cell
    for _ in range(3):
        finer *= (unknowns(tool(law, finer, press, slide)()) / wanted) ** 0.5
    runs = common.by_turns(soft, tool(law, finer, press, slide), repeats=3)
    own, other = (min(r.seconds for r in turns) for turns in runs)
    sizes = wanted, unknowns(runs[1][0])
    row(f"{label}: seconds at equal unknowns", "<= 1.5 x", f"{own:.3f} / {other:.3f} = {own / other:.2f}, unknowns {sizes}", own <= 1.5 * other)


def unknowns(found):
    return sum(v for v in found.last["unknowns"].values())


def main():
    common.arguments(__doc__, cell=0.05)
    cell = 0.1 if common.given.quick else common.given.cell
    kinds = {"linear": elastic, "incompressible": lambda e: elastic(e, 0.5), "rubber": rubber}
    for kind, law in kinds.items():
        press, slide = (0.1, 0.1) if kind == "rubber" else (0.02, 0.0)
        rigid = [tool(law(1.0), cell, press, slide), plate(law(1.0), cell, press, slide)]
        for contrast in CONTRASTS:
            tell(f"{kind} {contrast:g}:1", rigid, both((law(contrast), law(1.0)), cell, press, slide), 1.3)
            upwards = both((law(contrast), law(1.0)), cell, press, slide, "block")
            tell(f"{kind} {contrast:g}:1, the soft one moved", rigid, upwards, 1.3)
            if kind != "rubber":
                alone = [pressed(law(1.0), cell, 0.01)]
                tell(f"{kind}, floating 1:{contrast:g}", alone, floating((law(1.0), law(contrast)), cell, 0.01), 1.6)
                tell(f"{kind}, floating {contrast:g}:1", alone, floating((law(contrast), law(1.0)), cell, 0.01), 1.6)
        timed(kind, law(1.0), cell, press, slide)
    common.finish()


if __name__ == "__main__":
    main()
