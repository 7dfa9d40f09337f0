"""A force that jax and torch differentiate: its value and its gradient come from one solve.

The hardness of a block of rubber is found for which a press takes a given force at a given depth, by
Newton's method on the exact derivative: no solve is spent on a difference quotient.

`Goal` needs neither package. `in_jax` makes a function with a `jax.custom_vjp` of it, `in_torch` a
`torch.autograd.Function`; both take a vector with one number for each parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import signorini as s

#: Parameters of goals, and the keys of the scene that set them.
PARAMETERS = {
    "material.body.c10": "material.body.c10",
    "obstacle.press.translation.z": "step.0.obstacle.press.translation.2",
}


class Goal:
    """A goal of a scene as a function of some of its parameters."""

    def __init__(self, scene: str | Path, goal: str, parameters: Mapping[str, str], **changes: Any) -> None:
        """`parameters`: by their names in a gradient, the keys that set them; `changes` of all solves."""
        self.scene, self.goal, self.parameters = scene, goal, dict(parameters)
        self.changes = {"gradient": [{"of": goal, "to": list(parameters)}], **changes}

    def __call__(self, values: Any) -> tuple[float, np.ndarray[Any, Any]]:
        """The value, and its derivative by each parameter, [parameters]."""
        numbers = np.asarray(values, dtype=float).tolist()
        keys = dict(zip(self.parameters.values(), numbers, strict=True))
        last = s.solve(self.scene, set={**self.changes, **keys}).check()
        found = last.goal(self.goal)
        missing = ", ".join(name for name in self.parameters if name not in found.derivatives)
        if missing:
            raise s.errors.GoalError(f"no derivative by {missing}: {last.report.goals_refused}")
        return found.value, np.array([found.derivatives[name] for name in self.parameters])


def in_jax(goal: Goal) -> Callable[[Any], Any]:
    """The goal as a function of jax, for `jax.grad` and `jax.jit`."""
    import jax
    import jax.numpy as jnp

    def both(values: Any) -> Any:
        like = (jax.ShapeDtypeStruct((), values.dtype), jax.ShapeDtypeStruct(values.shape, values.dtype))

        def solved(numbers: Any) -> Any:
            value, gradient = goal(numbers)
            return np.asarray(value, values.dtype), gradient.astype(values.dtype)

        return jax.pure_callback(solved, like, values)

    @jax.custom_vjp
    def function(values: Any) -> Any:
        return both(values)[0]

    def backward(gradient: Any, weight: Any) -> tuple[Any]:
        return (jnp.multiply(weight, gradient),)

    function.defvjp(both, backward)
    return function


def in_torch(goal: Goal) -> Callable[[Any], Any]:
    """The goal as a function of torch, for `backward`."""
    import torch

    class Function(torch.autograd.Function):
        """One solve forward, none backward."""

        @staticmethod
        def forward(context: Any, values: Any) -> Any:
            value, gradient = goal(values.detach().cpu().numpy())
            context.save_for_backward(values.new_tensor(gradient))
            return values.new_tensor(value)

        @staticmethod
        def backward(context: Any, weight: Any) -> Any:
            (gradient,) = context.saved_tensors
            return weight * gradient

    return Function.apply


def matched(target: float, depth: float, tolerance: float = 1e-9) -> tuple[float, int]:
    """c10 for which the press takes the force `target` at a depth, and how many solves that took."""
    place = PARAMETERS["obstacle.press.translation.z"]
    force = Goal(
        s.example("mr-block"),
        "force.press.z",
        {"material.body.c10": "material.body.c10"},
        **{place: -depth, "step.0.increments": 2},
    )
    hardness = 0.4
    for solves in range(1, 20):
        value, (slope,) = force([hardness])
        if abs(value - target) <= tolerance * abs(target):
            return hardness, solves
        hardness -= (value - target) / slope
    raise RuntimeError("Newton's method has not ended")


def main() -> None:
    """Finds the hardness."""
    hardness, solves = matched(-0.2, depth=0.05)
    print(f"c10 {hardness:.6f} in {solves} solves")


if __name__ == "__main__":
    main()
