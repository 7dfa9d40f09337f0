#!/usr/bin/env python3
"""Draws the last result of a scene: the deformed body with its von Mises stress, solids from obliquely below with their
contact pressure, the tools, and in red the paths on which fluids leak first.

usage: draw.py RESULTS_FOLDER PICTURE.png [WIDTH]      needs `pip install meshio matplotlib pyvista`
"""
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import meshio
import numpy as np
import pyvista
from matplotlib.collections import LineCollection
from matplotlib.tri import Triangulation


def von_mises(stress):
    """From xx, yy, zz, xy, yz, xz."""
    xx, yy, zz, xy, yz, xz = stress.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + yz**2 + xz**2))


def body(axes, path):
    """The deformed cells of a file, their edges as the quadratic displacement bends them."""
    mesh = meshio.read(path)
    cells = mesh.cells_dict["triangle6"]
    moved = mesh.points[:, :2] + mesh.point_data["displacement"][:, :2]
    a, b, c, ab, bc, ca = cells.T
    triangles = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    values = von_mises(mesh.cell_data_dict["stress"]["triangle6"])
    shown = axes.tripcolor(Triangulation(*moved.T, triangles), np.tile(values, 4), cmap="viridis",
                           vmax=np.quantile(values, 0.995))
    sides = np.concatenate([np.stack(s, 1) for s in ((a, ab, b), (b, bc, c), (c, ca, a))])
    axes.add_collection(LineCollection(moved[sides], colors="white", linewidths=0.25, alpha=0.6))
    return shown, moved


def tools(axes, folder, number):
    for path in sorted(folder.glob(f"*_{number}.vtp")):
        tool = pyvista.read(path)
        for k in range(tool.n_cells):
            points = tool.get_cell(k).points[:, :2].T
            is_leak = "_leak_" in path.name
            axes.plot(*points, **({"color": "red", "linewidth": 2.5} if is_leak else {"color": "0.35", "linewidth": 1.5, "zorder": 0}))


def solid(path, folder, picture):
    """A body in space, its tools beside it."""
    mesh = meshio.read(path)
    name = next(name for name in mesh.cells_dict if name.startswith("tetra"))
    cells = mesh.cells_dict[name][:, :4]
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: cells}, mesh.points + mesh.point_data["displacement"])
    grid.point_data["contact pressure"] = np.nan_to_num(mesh.point_data["contact_pressure"])
    plotter = pyvista.Plotter(off_screen=True, window_size=(640, 460))
    plotter.add_mesh(grid.extract_surface(algorithm="dataset_surface"), scalars="contact pressure", cmap="viridis", show_edges=True,
                     edge_color="white", line_width=0.4, scalar_bar_args={"vertical": True, "color": "black", "position_x": 0.82, "title": "pressure"})
    for tool in sorted(folder.glob(f"*_{path.stem.split('_')[-1]}.vtp")):
        plotter.add_mesh(pyvista.read(tool), color="lightgrey", opacity=0.35, smooth_shading=True)
    low, high = np.array(grid.bounds).reshape(3, 2).T
    middle, size = (low + high) / 2, np.linalg.norm(high - low)
    plotter.camera_position = [middle + size * np.array([0.7, -1.3, -0.75]), middle, (0, 0, 1)]
    plotter.set_background("white")
    plotter.screenshot(picture)


def main():
    folder, picture = Path(sys.argv[1]), sys.argv[2]
    last = sorted(folder.glob("*.vtu"))[-1]
    if any(name.startswith("tetra") for name in meshio.read(last).cells_dict):
        return solid(last, folder, picture)
    figure, axes = plt.subplots(figsize=(4.2, 3.2), dpi=110)
    shown, moved = body(axes, last)
    low, high = moved.min(0), moved.max(0)
    margin = 0.08 * (high - low).max()
    tools(axes, folder, last.stem.split("_")[-1])
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    axes.axis("off")
    figure.colorbar(shown, shrink=0.7, label="von Mises stress")
    figure.savefig(picture, bbox_inches="tight")


main()
