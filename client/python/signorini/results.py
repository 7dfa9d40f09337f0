"""Results: the increments of a solve, with their numbers, fields, tables and pictures."""

from __future__ import annotations

from typing import Any

from . import _html, plot
from ._solution import Field, Increment, Iteration, Solution

__all__ = ["Field", "Increment", "Iteration", "Result"]


class Result(Solution):
    """All increments of a solve, in order. What an increment says, the result says of its last one."""

    def plot(self, field: str = "displacement", **options: Any) -> Any:
        """Draws a field on the deformed body; see `signorini.plot.draw`."""
        return plot.draw(self, field, **options)

    def plot_force(self, *obstacles: str, **options: Any) -> Any:
        """Draws force against travel with its error band; see `signorini.plot.curves`."""
        return plot.curves(self, obstacles, **options)

    def _repr_html_(self) -> str:
        """For notebooks: a table, warnings, and the curve of forces where matplotlib is there."""
        return _html.page(self)
