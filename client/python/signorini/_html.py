"""What a notebook shows of a result: the last increments, warnings, and the curve of forces."""

from __future__ import annotations

import io
from html import escape
from typing import Any

from ._solution import Solution
from .plot import curves

MOST_ROWS = 20
COLUMNS = ("step", "increment", "termination", "max_penetration", "seconds")


def page(result: Solution) -> str:
    """The whole."""
    title = f"<b>{escape(result.plan.name)}</b>: {state(result)}"
    notes = "".join(f"<li>{escape(one.message)}</li>" for one in result.warnings)
    return f"<div>{title}{table(result)}{f'<ul>{notes}</ul>' if notes else ''}{curve(result)}</div>"


def state(result: Solution) -> str:
    """How it ended."""
    count = f"{len(result)} increment{'s' if len(result) != 1 else ''}"
    if result.converged:
        return f"{count}, converged"
    return f"{count}, <b>not converged</b> ({escape(str(result.report.cause))})"


def table(result: Solution) -> str:
    """The last rows, with the force of each obstacle."""
    first = max(len(result) - MOST_ROWS, 0)
    forces = list(result.obstacles) if len(result) else []
    head = "".join(f"<th>{escape(one)}</th>" for one in (*COLUMNS, *(f"force of {name}" for name in forces)))
    rows = result.table()
    body = []
    for index in range(first, len(result)):
        cells = [rows[one][index] for one in COLUMNS]
        cells += [result[index].obstacles[name].force for name in forces]
        body.append("<tr>" + "".join(f"<td>{escape(shown(cell))}</td>" for cell in cells) + "</tr>")
    left = f"<tr><td colspan={len(COLUMNS)}>… {first} before</td></tr>" if first else ""
    return f"<table><tr>{head}</tr>{left}{''.join(body)}</table>"


def shown(value: Any) -> str:
    """Numbers with six digits."""
    if hasattr(value, "tolist"):
        return "(" + ", ".join(f"{one:.6g}" for one in value.tolist()) + ")"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def curve(result: Solution) -> str:
    """Force against travel as a drawing, where matplotlib is there and an obstacle moves."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return ""
    moved = [name for name in result.obstacles if result.travel(name)] if len(result) > 1 else []
    if not moved:
        return ""
    figure = Figure(figsize=(5, 3), layout="constrained")
    curves(result, moved, ax=figure.subplots())
    text = io.StringIO()
    figure.savefig(text, format="svg")
    drawing = text.getvalue()
    return drawing[drawing.index("<svg") :]
