"""Several sessions at one time: the force of an O-ring for four hardnesses, asynchronously."""

import asyncio

import signorini as s
from signorini import aio


async def force(c10: float) -> float:
    """The closing force at a squeeze of 5 %."""
    changes = {
        "material.rubber.c10": c10,
        "step": [{"load": 0.0, "increments": 2, "obstacle": {"lid": {"translation": [0, -0.2665, 0]}}}],
    }
    result = await aio.solve(s.example("o-ring"), set=changes)
    return float(-result.obstacles["lid"].force[1])


async def main() -> None:
    """All at once; the server takes them as it has room."""
    hardnesses = [0.4, 0.8, 1.2, 1.6]
    for c10, one in zip(hardnesses, await asyncio.gather(*map(force, hardnesses)), strict=True):
        print(f"c10 {c10:.1f} MPa: {one:.1f} N")


if __name__ == "__main__":
    asyncio.run(main())
