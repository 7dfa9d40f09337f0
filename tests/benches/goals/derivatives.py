#!/usr/bin/env python3
"""Derivatives of goals against differences of whole solves, on the random scenes of `bounds.py`.

Each scene draws one parameter that its goal can depend on: constants of the law, the place, the size or the friction of
the tool, loads, what the base prescribes. The derivative is compared with central differences of two steps, each of
solves at a tolerance of 1e-12, where the same points touch on both sides (`borderline` counts those that are about to
change). A pair is left where the goal itself is not told, or does not depend on the parameter.

usage: derivatives.py [COUNT [SEED]] [--rough]
SIGNORINI names the program, PATIENCE the seconds of one solution. Needs `pip install gmsh`.
"""
import argparse
import random
import re
import subprocess
import tempfile
from pathlib import Path

import bounds

# Steps of the differences, over the value of the parameter or 1.
STEPS = (1e-4, 1e-5)
# The largest difference, over the derivative, that agrees; derivatives below ZERO of goal over parameter count as that.
AGREES, ZERO = 1e-6, 1e-3
TIGHT = "[solver]\ntolerance = 1e-12\n"
NUMBER = r"-?\d+(?:\.\d*)?(?:e-?\d+)?"


def places(text):
    """Parameters of a scene: name, the pattern in front of its number, and how many numbers lie between."""
    law = [(f"material.body.{key}", rf"\n{key} = ") for key in ("shear_modulus", "c10", "c01", "bulk_modulus")]
    up = 2 if "[0.0, 0.0, -" in text or 'kind = "' not in text.split("[material")[0] else 1
    axis = "xyz"[up]
    skipped = rf"(?:{NUMBER}, ){{{up}}}"
    own = [
        (f"obstacle.tool.translation.{axis}", rf"translation = \[{skipped}"),
        ("obstacle.tool.radius", r'kind = "sphere".*?radius = '),
        ("obstacle.tool.tube_radius", "tube_radius = "),
        ("obstacle.tool.rounding", r"rounding = (?=0\.0[1-9])"),
        ("obstacle.tool.friction", "friction = "),
        (f"support.base.{axis}", rf'name = "base".*?{axis} = '),
    ]
    pulled = [(f"traction.0.{side}", rf"value = \[{rf'(?:{NUMBER}, ){{{place}}}'}") for place, side in enumerate("xy")]
    return [(name, found) for name, pattern in law + own + pulled
            if (found := re.search(rf"({pattern})({NUMBER})", text, re.DOTALL)) and (float(found[2]) or "support" in name)]


def moved(text, found, value):
    return text[: found.start(2)] + repr(value) + text[found.end(2):]


def pair(rng, folder, is_rough):
    """Name of scene, goal and parameter, the derivative and its differences over it, and points about to change."""
    text, goal, name = bounds.scene(rng, folder)
    text = (bounds.rough(rng, text) if is_rough else text) + TIGHT
    parameter, found = rng.choice(places(text))
    _, step = bounds.run(folder, text + f'[[gradient]]\nof = "{goal}"\nto = ["{parameter}"]\n')
    if parameter not in step.get("goals", {}).get(goal, {}).get("derivatives", {}):
        raise RuntimeError(str(step.get("goals_refused", "no derivative")))
    own, at = step["goals"][goal], float(found[2])
    derivative, differences = own["derivatives"][parameter], []
    for part in STEPS:
        width = part * max(abs(at), 0.01)
        ends = [bounds.value(bounds.run(folder, moved(text, found, at + side * width))[1], goal) for side in (1, -1)]
        differences.append((ends[0] - ends[1]) / (2 * width))
    size = max(abs(derivative), ZERO * abs(bounds.value(step, goal)) / max(abs(at), 0.01), 1e-300)
    return name, goal, parameter, derivative, [abs(own - derivative) / size for own in differences], own.get("borderline", 0)


def main():
    asked = argparse.ArgumentParser()
    asked.add_argument("count", nargs="?", type=int, default=60)
    asked.add_argument("seed", nargs="?", type=int, default=1)
    asked.add_argument("--rough", action="store_true")
    asked = asked.parse_args()
    agree, away, none = 0, 0, 0
    for number in range(asked.count):
        rng = random.Random(f"{asked.seed}-{number}")
        with tempfile.TemporaryDirectory() as folder:
            try:
                name, goal, parameter, value, off, borderline = pair(rng, Path(folder), asked.rough)
            except (RuntimeError, subprocess.SubprocessError) as error:
                none += 1
                print(f"{number:4} none: {str(error)[:160]}", flush=True)
                continue
        agree, away = agree + (min(off) <= AGREES), away + (min(off) > AGREES)
        print(f"{number:4} {name:44} {goal:22} {parameter:30} {value:12.5e} off {off[0]:.1e} {off[1]:.1e} "
              f"borderline {borderline}", flush=True)
    print(f"{agree + away} pairs: {agree} within {AGREES}, {away} not; {none} scenes without one")


if __name__ == "__main__":
    main()
