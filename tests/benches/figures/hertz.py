#!/usr/bin/env python3
"""hertz-sphere and hertz-plane on levels 1 to 5, quadratic contact space against the linear one, each in fresh processes by turns.

Ratios of cold seconds, of peak memory and of the seconds of the contact phase (medians), counts of applications over
the levels, and limits and errors of force, peak pressure and contact radius.
"""
import common
import limits
from common import by_turns, case, case_mesh, median, row, solve

SPACES = ("linear", "quadratic")
SCENES = {"hertz-sphere": ("indent", "ball"), "hertz-plane": ("hemi", "floor")}


def level(scene, number, repeats):
    mesh = case_mesh(f"{SCENES[scene][0]}_l{number}")
    runs = [lambda s=s: solve(case(f"{scene}.toml"), f"mesh={mesh}", f"solver.contact_space={s}") for s in SPACES]
    linear, quadratic = by_turns(*runs, repeats=repeats)
    def ratio(of):
        a, b = median([of(r) for r in linear]), median([of(r) for r in quadratic])
        return f"{b:.3g}/{a:.3g} = {b / a:.2f}", b / a
    label = f"{scene} l{number}"
    for what, most, of in (
        ("cold seconds", 1.2, lambda r: r.seconds),
        ("peak memory, MB", 1.15, lambda r: r.memory),
        ("seconds of contact", 1.5, lambda r: r.last["seconds"]["contact"]),
    ):
        words, value = ratio(of)
        row(f"{label}: {what}, quadratic over linear", f"<= {most}", words, value <= most)
    return {"linear": linear[0], "quadratic": quadratic[0]}


def main():
    common.arguments(__doc__, repeats=3)
    levels = (1, 2) if common.given.quick else (1, 2, 3, 4, 5)
    for scene, (_, obstacle) in SCENES.items():
        runs = [level(scene, number, common.given.repeats) for number in levels]
        for space in SPACES:
            counts = [sum(r[space].applications) for r in runs]
            asked = "flat: largest <= 1.3 x the mean"
            row(f"{scene} {space}: applications over levels", asked, str(counts), max(counts) <= 1.3 * sum(counts) / len(counts))
        if len(levels) > 2:
            limits.compare(scene, {s: [r[s].last for r in runs] for s in SPACES}, obstacle, levels)
    common.finish()


main()
