"""Two sessions coupled at a surface, as two codes would be: Dirichlet-Neumann with relaxation.

A bar of two materials is cut in two. The stiff half is held at its left end and takes forces on the
cut (Neumann); the soft half is moved on the cut (Dirichlet) and pressed by a roll on its top. Each
half is a session of its own. Per step, until the cut no longer moves:

    F = forces of the support that moves the soft half, by node     (field `nodal_force`)
    t = M^-1 F, M the mass matrix of the cut                        (a load density has those forces)
    u = displacement of the stiff half on the cut under -t
    g = g + w (u - g), w after Aitken                               moves the soft half next

Every pass begins with both sessions where the step began: `save` before it, `restore` between passes.
The result is that of the bar in one piece.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import signorini as s

LENGTHS = {"stiff": (0.0, 1.0), "soft": (1.0, 2.0), "whole": (0.0, 2.0)}
STIFF = s.LinearElastic(shear_modulus=1.0, poisson_ratio=0.3)
SOFT = s.LinearElastic(shear_modulus=0.3, poisson_ratio=0.3)
#: The roll goes down by so much at the end of each step.
DEPTHS = (0.03, 0.05)
#: Of the first change in a step; Aitken's rule finds the later ones.
RELAXATION = 0.5
#: The cut moves by no more than this part of its displacement.
SETTLED = 1e-9
MOST_PASSES = 60


def bar(part: str, cells: int = 8) -> s.Mesh:
    """A part of the bar [0, 2] x [0, 1], of triangles that are the same in every part."""
    low, high = LENGTHS[part]
    along = np.linspace(low, high, round(cells * (high - low)) + 1)
    x, y = np.meshgrid(along, np.linspace(0.0, 1.0, cells + 1), indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    corner = (np.arange(len(along) - 1)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    right, up = corner + cells + 1, corner + 1
    triangles = np.concatenate([np.stack([corner, right, up], axis=1), np.stack([right, right + 1, up], axis=1)])
    sides = s.boundary(triangles)
    middle = points[sides].mean(axis=1)
    centre = points[triangles].mean(axis=1)[:, 0]
    places = {"clamp": middle[:, 0] < 1e-9, "top": (middle[:, 1] > 1 - 1e-9) & (middle[:, 0] > 1)}
    places["cut"] = np.abs(middle[:, 0] - 1) < 1e-9
    surfaces = {name: sides[there] for name, there in places.items() if there.any()}
    bodies = {name: there for name, there in {"stiff": centre < 1, "soft": centre > 1}.items() if there.any()}
    return s.Mesh(points, triangles, bodies=bodies, surfaces=surfaces)


def scene(part: str) -> s.Scene:
    """A part of the bar with what acts on it."""
    clamp = s.Support(name="clamp", on="clamp", displacement={"x": 0.0, "y": 0.0})
    moved = s.Support(name="cut", on="cut", displacement={"x": 0.0, "y": 0.0})
    roll = s.Obstacle(name="roll", on="top", shape=s.Cylinder(point=(1.6, 1.5, 0), axis=(0, 0, 1), radius=0.5))
    stiff, soft = {"stiff": STIFF}, {"soft": SOFT}
    return s.Scene(
        mesh=bar(part),
        kind="plane-strain",
        materials={"stiff": stiff, "soft": soft, "whole": stiff | soft}[part],
        supports=[moved] if part == "soft" else [clamp],
        tractions=[s.Traction(name="cut", on="cut", value=(0, 0, 0))] if part == "stiff" else [],
        obstacles=[] if part == "stiff" else [roll],
        solver=s.Solver(tolerance=1e-11),
    )


def mass(mesh: s.Mesh, nodes: Any) -> Any:
    """Mass matrix of the quadratic functions on the cut, [nodes, nodes]."""
    matrix = np.zeros((len(nodes), len(nodes)))
    for facet in mesh.facet_nodes("cut"):
        length = np.linalg.norm(mesh.places[facet[0]] - mesh.places[facet[1]])
        own = np.searchsorted(nodes, facet)
        matrix[np.ix_(own, own)] += length / 30 * np.array([[4, -1, 2], [-1, 4, 2], [2, 2, 16]])
    return matrix


def coupled() -> tuple[Any, list[int]]:
    """Displacement of the soft half at the end, and the passes of each step."""
    fields = ["displacement", "nodal_force"]
    with s.session(scene("stiff"), fields=fields) as stiff, s.session(scene("soft"), fields=fields) as soft:
        cut = {one: one.mesh.nodes("cut") for one in (stiff, soft)}
        matrix = mass(soft.mesh, cut[soft])
        moved, passes = np.zeros((len(cut[soft]), 3)), []
        for depth in DEPTHS:
            saved = {one: one.save() for one in (stiff, soft)}
            relaxation, before = RELAXATION, np.zeros_like(moved)
            for count in range(1, MOST_PASSES + 1):
                if count > 1:
                    stiff.restore(saved[stiff])
                    soft.restore(saved[soft])
                values = s.Values(rows=moved, numbers=cut[soft])
                update = soft.step(supports={"cut": {"values": values}}, obstacles={"roll": (0, -depth, 0)})
                force = update.result().fields["nodal_force"][cut[soft]]
                # What moves the soft half pulls at the stiff one.
                pull = s.Values(rows=-np.linalg.solve(matrix, force), numbers=cut[stiff])
                there = stiff.step(tractions={"cut": {"values": pull}}).result().fields["displacement"][cut[stiff]]
                change = there - moved
                if np.abs(change).max() <= SETTLED * np.abs(there).max():
                    break
                if count > 1:
                    bend = change - before
                    relaxation *= -float(np.sum(before * bend) / np.sum(bend * bend))
                moved, before = moved + relaxation * change, change
            passes.append(count)
            displacement = np.array(update.result().fields["displacement"])
    return displacement, passes


def monolithic() -> Any:
    """Displacement of the nodes of the soft half, the bar solved in one piece."""
    with s.session(scene("whole"), fields=["displacement"]) as whole:
        for depth in DEPTHS:
            increment = whole.step(obstacles={"roll": (0, -depth, 0)}).result()
    places, displacement = whole.mesh.places, increment.fields["displacement"]
    there = dict(zip(keys(places), displacement, strict=True))
    return np.array([there[place] for place in keys(bar("soft").places)])


def keys(places: Any) -> list[tuple[float, ...]]:
    """Places by which nodes of two meshes are found."""
    return [tuple(place) for place in (places.round(9) + 0.0).tolist()]


def main() -> None:
    """Prints the passes, and how far the coupled bar is from that in one piece."""
    displacement, passes = coupled()
    expected = monolithic()
    difference = np.abs(displacement - expected).max() / np.abs(expected).max()
    print(f"passes per step {passes}, relative difference from one piece {difference:.1e}")
    assert difference <= 1e-6


if __name__ == "__main__":
    main()
