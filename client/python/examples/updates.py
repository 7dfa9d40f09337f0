"""Two hundred updates of an obstacle by 1 %, each sent when the one before is answered: how many a second.

python updates.py ../../examples/hertz-sphere.toml ../../examples/meshes/indent_l1.msh
"""

import sys
import time

import signorini as s

COUNT = 200


def main() -> None:
    """Prints updates a second, and the part of the time that the solver itself took."""
    scene, mesh = sys.argv[1:3]
    with s.session(scene, s.Mesh.read(mesh), set={"solver.tolerance": 1e-6}) as session:
        session.step(obstacles={"ball": (0, 0, -0.05)}).result()
        solver, start = 0.0, time.perf_counter()
        for index in range(COUNT):
            depth = 0.05 * (1 + 0.01 * (index % 10))
            solver += session.move(ball=(0, 0, -depth)).result().report.seconds.total
        elapsed = time.perf_counter() - start
    print(f"{COUNT / elapsed:.1f} updates/s, {1e3 * elapsed / COUNT:.3f} ms each, {solver / elapsed:.1%} the solver")


if __name__ == "__main__":
    main()
