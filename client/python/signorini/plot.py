"""Pictures of results: fields on the deformed body with pyvista, curves with matplotlib.

Without pyvista a section (triangles) is drawn with matplotlib. Fields of the contact surface are
drawn there, all others on the body.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._outlines import outlines
from ._solution import Increment, Solution
from .mesh import boundary

__all__ = ["curves", "dataset", "draw"]

Floats = npt.NDArray[np.float64]

#: Fields that live on the contact surface only.
ON_SURFACE = (
    "contact_pressure",
    "contact_pressure_deformed",
    "contact_pressure_undeformed",
    "gap",
    "contact_state",
    "friction_traction",
    "slip",
)
COLOURS = "viridis"
#: The bar of colours: over the lines of obstacles, its title above the numbers.
BAR = {"color": "black", "vertical": False, "n_labels": 4, "fill": True, "background_color": "white"}
BAR |= {"width": 0.6, "height": 0.11, "position_x": 0.2, "position_y": 0.01, "title_font_size": 16}
#: Fields by the quantity that names their unit.
QUANTITIES = {
    "length": ("displacement", "gap", "slip"),
    "stress": (
        "pressure",
        "contact_pressure",
        "contact_pressure_deformed",
        "contact_pressure_undeformed",
        "friction_traction",
        "stress",
    ),
    "force": ("nodal_force",),
}


def named(text: str, result: Solution, quantity: str) -> str:
    """A text with the unit of its quantity, where the scene names it."""
    unit = getattr(result.scene.units, quantity, "")
    return f"{text} ({unit})" if unit else text


def title(result: Solution, field: str) -> str:
    """What a field is called in pictures."""
    quantity = next((one for one, fields in QUANTITIES.items() if field in fields), "")
    return named(field.replace("_", " "), result, quantity)


def positions(result: Solution, increment: Increment, warp: float) -> Floats:
    """Where the vertices are; `warp` multiplies the displacement."""
    shift = increment.fields.get("displacement")
    points = result.mesh.points * scale(result)
    return points if shift is None else points + warp * shift[: len(points)]


def scale(result: Solution) -> float:
    """What the scene multiplies the coordinates by."""
    return float(result.scene.mesh_scale) if result.scene.HasField("mesh_scale") else 1.0


def scalars(increment: Increment, field: str) -> Floats:
    """One number a row: lengths of vectors, von Mises of stresses."""
    values = increment.fields[field]
    if values.ndim == 1:
        return values
    if values.shape[1] == 6:
        return von_mises(values)
    return np.asarray(np.linalg.norm(values, axis=1))


def von_mises(stress: Floats) -> Floats:
    """From xx yy zz xy yz zx."""
    xx, yy, zz, xy, yz, zx = stress.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3 * (xy**2 + yz**2 + zx**2)))


def dataset(result: Solution, increment: int = -1, warp: float = 1.0) -> Any:
    """The deformed body with all fields, as a `pyvista.UnstructuredGrid`."""
    import pyvista as pv

    one = result[increment]
    kind = pv.CellType.TRIANGLE if result.mesh.dimension == 2 else pv.CellType.TETRA
    grid = pv.UnstructuredGrid({kind: result.mesh.cells}, positions(result, one, warp))
    for name, values in one.fields.items():
        if name == "contact_path":
            continue  # Of points along the surface.
        if len(values) == len(result.mesh.cells):
            grid.cell_data[name] = values
        else:
            grid.point_data[name] = values[: len(result.mesh.points)]
    return grid


def draw(
    result: Solution,
    field: str = "displacement",
    *,
    increment: int = -1,
    warp: float = 1.0,
    file: str | Path | None = None,
    show: bool | None = None,
    size: tuple[int, int] = (1024, 768),
) -> Any:
    """Draws a field on the deformed body; gives the `pyvista.Plotter`, or the axes of matplotlib.

    With `file` the picture is written there and no window opens; `show` opens one, which is also
    what happens without `file` unless it is False.
    """
    try:
        import pyvista
    except ImportError:
        if result.mesh.dimension == 3:
            raise ImportError("pictures of solids need pyvista: pip install signorini[plot]") from None
        return draw_section(result, field, result[increment], warp, file)
    plotter = pyvista.Plotter(off_screen=file is not None or show is False, window_size=list(size))
    fill(plotter, result, field, increment, warp)
    if file is not None:
        plotter.screenshot(os.fspath(file))
    elif show is not False:
        plotter.show()
    return plotter


def fill(plotter: Any, result: Solution, field: str, increment: int, warp: float) -> None:
    """Puts the body into the scene of a plotter."""
    plotter.set_background("white")
    values = scalars(result[increment], field)
    grid = dataset(result, increment, warp)
    bar = {**BAR, "title": title(result, field) + "\n"}
    on_cells = len(values) == len(result.mesh.cells) and field not in ON_SURFACE
    target = grid.cell_data if on_cells else grid.point_data
    target["drawn"] = values[: len(result.mesh.cells if on_cells else result.mesh.points)]
    plane = result.mesh.dimension == 2
    style = {"show_edges": True, "edge_color": "grey", "line_width": 0.5, "ambient": 0.4}
    if plane and field in ON_SURFACE:
        plotter.add_mesh(grid, color="lightgrey", **style)
        plotter.add_mesh(skin_of(grid, result), scalars="drawn", cmap=COLOURS, line_width=8, scalar_bar_args=bar)
    else:
        plotter.add_mesh(grid, scalars="drawn", cmap=COLOURS, scalar_bar_args=bar, **style)
    for outline in outlines(result, result[increment], grid):
        plotter.add_mesh(outline, color="black" if plane else "steelblue", opacity=1.0 if plane else 0.15, line_width=2)
    axes = {f"{one}title": named(one, result, "length") for one in "xyz"}
    plotter.show_bounds(mesh=grid, color="black", location="outer", font_size=11, fmt="%.4g", use_2d=plane, **axes)
    # The body fills the view, however large an obstacle is.
    middle, towards = np.array(grid.center), np.array([0, 0, 1] if plane else [0.58, -0.58, 0.58])
    away = (2.3 if plane else 2.6) * grid.length * towards
    plotter.camera_position = [middle + away, middle, (0, 1, 0) if plane else (0, 0, 1)]


def skin_of(grid: Any, result: Solution) -> Any:
    """The boundary of a section as lines with the same values."""
    import pyvista as pv

    edges = boundary(result.mesh.cells)
    lines = pv.PolyData(grid.points, lines=np.insert(edges, 0, 2, axis=1).ravel())
    lines.point_data["drawn"] = grid.point_data["drawn"]
    return lines


def draw_section(result: Solution, field: str, increment: Increment, warp: float, file: str | Path | None) -> Any:
    """A section with matplotlib."""
    from matplotlib import pyplot
    from matplotlib.collections import LineCollection

    points, values = positions(result, increment, warp)[:, :2], scalars(increment, field)
    cells = result.mesh.cells
    figure, axes = pyplot.subplots(layout="constrained")
    axes.set_aspect("equal")
    if field in ON_SURFACE:
        axes.triplot(points[:, 0], points[:, 1], cells, color="lightgrey", linewidth=0.5)
        edges = boundary(cells)
        drawn: Any = LineCollection(list(points[edges]), array=values[edges].mean(axis=1), linewidths=4, cmap=COLOURS)
        axes.add_collection(drawn)
    elif len(values) == len(cells):
        drawn = axes.tripcolor(points[:, 0], points[:, 1], triangles=cells, facecolors=values, cmap=COLOURS)
    else:
        shown = values[: len(points)]
        drawn = axes.tripcolor(points[:, 0], points[:, 1], shown, triangles=cells, shading="gouraud", cmap=COLOURS)
    figure.colorbar(drawn, label=title(result, field))
    axes.set_xlabel(named("x", result, "length"))
    axes.set_ylabel(named("y", result, "length"))
    if file is not None:
        figure.savefig(file)
    return axes


def curves(result: Solution, obstacles: Sequence[str] = (), *, ax: Any = None, file: str | Path | None = None) -> Any:
    """Draws the force along the travel against the travel, with the band of its error; the axes.

    Obstacles that stay are drawn by the size of their force against time; without names those that
    move are drawn, or all.
    """
    if ax is None:
        from matplotlib import pyplot

        ax = pyplot.subplots(layout="constrained")[1]
    moving = [name for name in result.obstacles if result.travel(name)]
    for name in obstacles or moving or list(result.obstacles):
        curve(result, name, ax)
    ax.set_xlabel(named("travel", result, "length") if moving else "time")
    ax.set_ylabel(named("force along the travel" if moving else "force", result, "force"))
    ax.grid(visible=True, alpha=0.3)
    ax.legend()
    if file is not None:
        ax.figure.savefig(file)
    return ax


def curve(result: Solution, name: str, ax: Any) -> None:
    """One obstacle."""
    moved = result.travel(name)
    if moved is None:
        along = np.array([one.report.time for one in result])
        force = np.linalg.norm(result.forces(name), axis=1)
    else:
        along, force = moved
    (line,) = ax.plot(along, force, marker="o", markersize=3, label=name)
    errors = [one.obstacles[name].force_error for one in result]
    band = np.array([np.nan if one is None else one for one in errors])
    ax.fill_between(along, force - band, force + band, color=line.get_color(), alpha=0.25, linewidth=0)
