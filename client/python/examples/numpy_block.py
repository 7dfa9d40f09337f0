"""A rubber block of numpy arrays under a cylinder, moved step by step; the state stays on the server."""

import numpy as np

import signorini as s


def block(cells: int) -> s.Mesh:
    """A square [-1, 1] x [0, 1] of triangles; surfaces by the place of their sides."""
    x, y = np.meshgrid(np.linspace(-1, 1, 2 * cells + 1), np.linspace(0, 1, cells + 1), indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    corner = (np.arange(2 * cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    right, up = corner + cells + 1, corner + 1
    triangles = np.concatenate([np.stack([corner, right, up], axis=1), np.stack([right, right + 1, up], axis=1)])
    sides = s.boundary(triangles)
    height = points[sides].mean(axis=1)[:, 1]
    return s.Mesh(points, triangles, surfaces={"base": sides[height < 1e-9], "top": sides[height > 1 - 1e-9]})


def main() -> None:
    """Presses, then rolls."""
    scene = s.Scene(
        mesh=block(12),
        kind="plane-strain",
        materials={"body": s.NeoHookean(shear_modulus=1.0)},
        supports=[s.Support(name="base", on="base", displacement={"x": 0.0, "y": 0.0})],
        obstacles=[s.Obstacle(name="roll", on="top", shape=s.Cylinder(point=(0, 2, 0), axis=(0, 0, 1), radius=1.0))],
    )
    with s.session(scene, fields=["contact_pressure"]) as session:
        for increment in session.step(increments=4, obstacles={"roll": (0, -0.1, 0)}):
            print("pressed", increment.obstacles["roll"].force.round(4))
        for place in np.linspace(0, 0.4, 5):
            increment = session.move(roll=(place, -0.1, 0)).result()
            pressure = increment.fields["contact_pressure"]
            print(f"at {place:.1f}", increment.obstacles["roll"].force.round(4), "largest", pressure.max().round(4))


if __name__ == "__main__":
    main()
