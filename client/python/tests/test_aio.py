"""The asynchronous twin."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from conftest import Proxy

import signorini as s
from signorini import aio


def test_increments_come_one_by_one(ball: s.Scene) -> None:
    async def main() -> list[s.Increment]:
        async with aio.session(ball, fields=["displacement"]) as session:
            update = await session.step(increments=3, obstacles={"ball": (0, 0, -0.05)})
            return [increment async for increment in update]

    increments = asyncio.run(main())
    assert [one.report.increment for one in increments] == [1, 2, 3]
    assert increments[-1].fields["displacement"].shape[1] == 3


def test_the_last_increment_is_waited_for_past_those_that_nobody_read(ball: s.Scene) -> None:
    async def main() -> tuple[int, list[int]]:
        async with aio.session(ball) as session:
            update = await session.step(increments=3, obstacles={"ball": (0, 0, -0.05)})
            last = await asyncio.wait_for(update.result(), 60)
            return last.report.increment, [one.report.increment async for one in update]

    assert asyncio.run(main()) == (3, [1, 2, 3])


def test_a_session_goes_back_to_a_saved_state(ball: s.Scene) -> None:
    async def main() -> list[bytes]:
        async with aio.session(ball, fields=["displacement"]) as session:
            await session.step(increments=2, obstacles={"ball": (0, 0, -0.02)})
            saved = await session.save()
            found = []
            for _ in range(2):
                update = await session.move(ball=(0, 0, -0.04))
                found.append((await update.result()).fields["displacement"].tobytes())
                await session.restore(saved)
            return found

    first, again = asyncio.run(main())
    assert first == again


def test_results_are_those_of_the_waiting_twin(ball: s.Scene) -> None:
    ball.steps = [s.Step(increments=2, obstacles={"ball": s.Move(translation=(0, 0, -0.05))})]
    result = asyncio.run(aio.solve(ball))
    np.testing.assert_array_equal(result.forces("ball"), s.solve(ball).forces("ball"))


def test_tasks_share_a_session_and_sessions_share_a_loop(ball: s.Scene) -> None:
    async def press(session: aio.Session, depth: float) -> float:
        update = await session.move(ball=(0, 0, -depth))
        return float((await update.result()).obstacles["ball"].force[2])

    async def main() -> list[list[float]]:
        async with aio.session(ball) as first, aio.session(ball) as second:
            tasks = [asyncio.gather(*(press(one, 0.01 * n) for n in range(1, 5))) for one in (first, second)]
            return [list(await task) for task in tasks]

    first, second = asyncio.run(main())
    assert first == second
    assert sorted(first, reverse=True) == first


def test_a_refused_update_is_an_error_of_its_own(ball: s.Scene) -> None:
    async def main() -> bool:
        async with aio.session(ball) as session:
            update = await session.move(bal=(0, 0, -0.01))
            with pytest.raises(s.errors.SceneError):
                await update.result()
            return (await (await session.move(ball=(0, 0, -0.01))).result()).converged

    assert asyncio.run(main())


def test_a_break_loses_and_repeats_nothing(ball: s.Scene, proxy: Proxy) -> None:
    async def main() -> list[float]:
        async with aio.session(ball, server=proxy.address) as session:
            updates = [await session.move(ball=(0, 0, -0.03 - 0.001 * n)) for n in range(20)]
            forces = []
            for index, update in enumerate(updates):
                if index % 7 == 3:
                    proxy.break_connections()
                forces.append(float((await update.result()).obstacles["ball"].force[2]))
            return forces

    forces = asyncio.run(main())
    assert len(forces) == 20
    assert all(np.diff(forces) < 0)
