#!/usr/bin/env python3
"""Draws the pictures of the scenes for the page of `signorini bench`: solves each on a coarse mesh and
shows the deformed body, coloured by how far it moves, with the obstacle.

usage: draw_scenes.py PROGRAM FOLDER [SCENE...]      needs `pip install pyvista`
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyvista

EXAMPLES = Path(__file__).resolve().parents[3] / "client" / "examples"
ROUGH = ["material.body.poisson_ratio=0.3", "obstacle.0.friction=0.3", "step.0.increments=4"]
# Scene file, mesh, changes, and how much the displacement is enlarged.
SCENES = {
    "A1m": ("manufactured", "cube_n6", [], 0.04),
    "cube-bend": ("cube-bend", "cube_n6", [], 0.2),
    "cube-drag": ("cube-drag", "cube_n6", [], 1.0),
    "hertz-plane": ("hertz-plane", "hemi_l2", [], 1.0),
    "hertz-press": ("hertz-plane", "hemi_l2", ROUGH, 1.0),
    "hertz-sphere": ("hertz-sphere", "indent_l2", [], 1.0),
    "mr-block": ("mr-block", "cube_n6", [], 1.0),
    "mr-sphere": ("mr-sphere", "indent_l2", [], 1.0),
    "mr-uniax": ("mr-uniax", "cube_n6", [], 1.0),
}


def solve(program, scene, folder):
    file, mesh, settings, _ = SCENES[scene]
    command = [program, "solve", EXAMPLES / f"{file}.toml", "--quiet", "--out", folder]
    for setting in [f"mesh={EXAMPLES / 'meshes' / mesh}.msh", *settings]:
        command += ["--set", setting]
    subprocess.run(command, check=True)


def draw(scene, folder, picture):
    last = sorted(folder.glob("*.vtu"))[-1]
    body = pyvista.read(last)
    body = body.warp_by_vector("displacement", factor=SCENES[scene][3]).extract_surface(
        nonlinear_subdivision=2, algorithm="dataset_surface"
    )
    plotter = pyvista.Plotter(off_screen=True, window_size=(440, 400))
    length = np.linalg.norm(body["displacement"], axis=1)
    # Light, so that the obstacle shows on it; nothing is read off a picture of this size.
    plotter.add_mesh(body, scalars=length, cmap="YlGnBu", clim=(0.0, 1.6 * length.max()), show_scalar_bar=False)
    plotter.add_mesh(body.extract_feature_edges(40), color="black", line_width=1.5)
    for path in sorted(folder.glob(f"*_{last.stem.split('_')[-1]}.vtp")):
        plotter.add_mesh(pyvista.read(path), color="grey", opacity=0.45)
    # The planes of symmetry of quarter models are in front.
    plotter.view_vector((-1.0, -1.6, 0.7))
    plotter.reset_camera(bounds=body.bounds)
    plotter.camera.zoom(1.1)
    # The page behind is light or dark.
    plotter.screenshot(picture, transparent_background=True)
    plotter.close()


def main():
    program, out = sys.argv[1], Path(sys.argv[2])
    for scene in sys.argv[3:] or SCENES:
        with tempfile.TemporaryDirectory() as name:
            solve(program, scene, Path(name))
            draw(scene, Path(name), out / f"{scene}.png")
            print(scene)


main()
