# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""rendered_run_test.py BIN_DIR SOURCE_DIR: a whole run on rendered raw frames, exported.

COLMAP itself reads it where it is installed; what it says of the errors is computed from the files
in any case.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import colmap_model

BIN_DIR, SOURCE_DIR = map(pathlib.Path, sys.argv[1:])
MAX_ERROR_PX = 0.3


def run(program, *arguments):
    result = subprocess.run([program, *map(str, arguments)], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if result.returncode != 0:
        raise AssertionError(f"{program}: {result.stdout}")
    return result.stdout


with tempfile.TemporaryDirectory() as name:
    raw, out = pathlib.Path(name) / "raw", pathlib.Path(name) / "out"
    run(BIN_DIR / "prism_simulate", "--trajectory=handheld", "--seed=15", "--truth_every=0",
        f"--scene={SOURCE_DIR}/test/end_to_end/desk.yaml",
        f"--camera={SOURCE_DIR}/test/end_to_end/camera.yaml", "--frames=20", f"--output_dir={raw}")
    said = run(BIN_DIR / "prism_vo", f"--sequence={raw}", f"--output_dir={out}",
               "--export=colmap,nerfstudio,kitti,euroc,mcap,ply,dense")
    for path in ("nerfstudio/transforms.json", "trajectory_kitti.txt", "trajectory_euroc.csv",
                 "run.mcap", "points_oriented.ply", "points_dense.ply"):
        assert (out / path).stat().st_size > 500, path
    model = colmap_model.Model(out / "colmap")
    errors = model.errors()
    mean = sum(errors) / len(errors)
    print(f"{len(model.images)} images, {len(model.points)} points, {len(errors)} observations, "
          f"mean reprojection error {mean:.3f} px")
    assert len(model.images) >= 3 and len(model.points) > 200, said
    assert mean <= MAX_ERROR_PX, said
    if shutil.which("colmap"):
        analysis = run("colmap", "model_analyzer", "--path", out / "colmap")
        theirs = float(re.search(r"Mean reprojection error: ([\d.]+)", analysis).group(1))
        print(f"COLMAP: {theirs} px")
        assert theirs <= MAX_ERROR_PX, analysis
    else:
        print("colmap is not installed: only read here (tools/install_deps.sh --with-readers)")
