#!/usr/bin/env python3
"""Two programs by turns, --signorini over --other: medians of the seconds of cube-bend, hertz (linear space), mr-block, mr-uniax.

Asked is at most 1.02 times, by the median of the ratios of the pairs. Keep the machine quiet.
"""
import common
from common import by_turns, case, case_mesh, close, median, row, solve

LINEAR = "solver.contact_space=linear"
SCENES = {
    "cube-bend n10": ("cube-bend.toml", "cube_n10", []),
    "cube-bend n16": ("cube-bend.toml", "cube_n16", []),
    "hertz-sphere l3": ("hertz-sphere.toml", "indent_l3", [LINEAR]),
    "hertz-plane l3": ("hertz-plane.toml", "hemi_l3", [LINEAR]),
    "mr-block n6": ("mr-block.toml", "cube_n6", []),
    "mr-uniax n6": ("mr-uniax.toml", "cube_n6", []),
}


def main():
    given = common.arguments(__doc__, other="", repeats=9)
    if not given.other:
        raise SystemExit("give the other program by --other")
    for label, (file, mesh, sets) in SCENES.items():
        sets = [f"mesh={case_mesh(mesh)}", *sets]
        runs = by_turns(*(lambda b=b: solve(case(file), *sets, binary=b) for b in (given.signorini, given.other)), repeats=3 if given.quick else given.repeats)
        ratio = median([a.seconds / b.seconds for a, b in zip(*runs)])
        counts = [sum(r[0].applications) for r in runs]
        times = [median([r.seconds for r in found]) for found in runs]
        energies = close(*(r[0].last["strain_energy"] for r in runs))
        row(f"{label}: seconds over the other's, median of {len(runs[0])} pairs", "<= 1.02",
            f"{ratio:.3f} ({times[0]:.3f} / {times[1]:.3f} s, {counts[0]} / {counts[1]} applications, energies apart by {energies:.0e})",
            ratio <= 1.02 and all(r.converged for found in runs for r in found))
    common.finish()


main()
