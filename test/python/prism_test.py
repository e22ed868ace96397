# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""prism_test.py MODULE_DIR BIN_DIR SOURCE_DIR: `import prism` on 20 rendered frames.

Exit status 77 (skipped) where numpy or OpenCV is not installed.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

MODULE_DIR, BIN_DIR, SOURCE_DIR = map(pathlib.Path, sys.argv[1:])
sys.path.insert(0, str(MODULE_DIR))
try:
    import cv2
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)
import prism

FRAMES = 20


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def run(program, *arguments):
    result = subprocess.run([str(BIN_DIR / program), *map(str, arguments)], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    check(result.returncode == 0, f"{program}: {result.stdout}")


def read_focused(folder):
    """time, image, 1/v, sigma of each frame, as a user would read them."""
    for line in (folder / "focused.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        time, *names = line.split()
        image, depth, sigma = (cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED)
                               for name in names)
        is_measured = depth > 0
        yield (float(time), image, np.where(is_measured, 1 - depth / 65535, 0),
               np.where(is_measured, sigma / 65535 * 0.1, 0))


def check_same_bytes(module, program):
    check(module.read_bytes() == (program / "trajectory.txt").read_bytes(),
          f"{module.name} is not what prism_vo writes")


def check_camera(folder):
    camera = prism.Camera.read(str(folder / "camera.yaml"))
    points = np.array([[0.1, -0.05, 0.8], [0, 0, 2.0], [0, 0, 0.01]])
    pixels = camera.project(points)
    check(np.isnan(pixels[2]).all(), "a point inside the focal length is projected")
    f, cx, cy = camera.pinhole
    zeta = points[0, 2] - camera.focal_length
    check(abs(pixels[0, 0] - (cx + f * points[0, 0] / zeta)) < 1e-9, "not the pinhole's pixel")
    check(np.allclose(camera.unproject(pixels[:2]), points[:2], atol=1e-9), "no way back")
    try:
        prism.Camera.read(str(folder / "missing.yaml"))
        check(False, "a missing file is read")
    except prism.InputError as error:
        check("missing.yaml: found" in str(error), str(error))
    return camera


def check_example(folder, picture):
    """The example runs, and its picture shows something."""
    try:
        import matplotlib
    except ImportError:
        print("matplotlib is not installed: the example is not run")
        return
    script = SOURCE_DIR / "prism/python/examples/plot_run.py"
    result = subprocess.run([sys.executable, str(script), str(folder), str(picture)], text=True,
                            env={**os.environ, "PYTHONPATH": str(MODULE_DIR)},
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    check(result.returncode == 0, result.stdout)
    check(f"{FRAMES} of {FRAMES} frames tracked" in result.stdout, result.stdout)
    check(picture.stat().st_size > 20000, "the picture is empty")


def main():
    with tempfile.TemporaryDirectory() as name:
        root = pathlib.Path(name)
        raw, focused = root / "raw", root / "focused"
        run("prism_simulate", "--trajectory=handheld", "--seed=15", "--truth_every=0",
            f"--scene={SOURCE_DIR}/test/end_to_end/desk.yaml",
            f"--camera={SOURCE_DIR}/test/end_to_end/camera.yaml", f"--frames={FRAMES}",
            f"--output_dir={raw}")
        run("prism_lightfield", f"--raw={raw}", f"--camera={raw}/camera.yaml",
            f"--output_dir={focused}")
        for sequence in (raw, focused):
            run("prism_vo", f"--sequence={sequence}", "--threads=1",
                f"--output_dir={root}/{sequence.name}_vo")
        camera = check_camera(focused)

        # Frame by frame, from arrays.
        odometry = prism.Odometry(camera, threads=1)
        for time, image, depth, sigma in read_focused(focused):
            result = odometry.process(image, depth, sigma, time)
            check(result.has_pose, result.status)
            check(result.world_from_cam.shape == (4, 4), "no matrix")
        odometry.write_trajectory(str(root / "arrays.txt"))
        check_same_bytes(root / "arrays.txt", root / "focused_vo")
        # Their images of virtual points as they are.
        run("prism_vo", f"--sequence={focused}", "--threads=1", "--focused_image=virtual_points",
            f"--output_dir={root}/virtual_vo")
        virtual = prism.Odometry(camera, threads=1, focused_image="virtual_points")
        for time, image, depth, sigma in read_focused(focused):
            virtual.process(image, depth, sigma, time)
        virtual.write_trajectory(str(root / "virtual.txt"))
        check_same_bytes(root / "virtual.txt", root / "virtual_vo")
        check(camera.pinhole_z == camera.focal_length and prism.Sequence(str(raw)).camera.pinhole_z == 0,
              "not where the pinhole stands")
        check(odometry.trajectory.shape == (FRAMES, 8), f"{odometry.trajectory.shape}")
        positions, colours, sigmas = odometry.points
        check(len(positions) == len(colours) == len(sigmas) > 500, f"{len(positions)} points")
        check(np.isfinite(positions).all() and (sigmas >= 0).all(), "points are not numbers")

        # A folder, as the program opens it, and its raw frames one by one.
        sequence = prism.Sequence(str(raw))
        check(len(sequence) == FRAMES and sequence.format == "raw", sequence.format)
        check("camera: camera.yaml of the folder" in sequence.report, f"{sequence.report}")
        by_folder = prism.Odometry(sequence.camera, threads=1)
        first = None
        for frame in sequence:
            if first is None:
                first = (np.array(frame.image), np.array(frame.sigma), frame.time)
                check(not frame.image.flags.owndata, "the image is a copy")
            by_folder.process_frame(frame)
        by_folder.write_trajectory(str(root / "folder.txt"))
        check_same_bytes(root / "folder.txt", root / "raw_vo")

        white = cv2.imread(str(raw / "white.png"), cv2.IMREAD_UNCHANGED)
        names = [line.split() for line in (raw / "raw.txt").read_text().splitlines()
                 if not line.startswith("#")]
        by_raw = prism.Odometry(sequence.camera, white=white, threads=1)
        light_field = prism.LightField(sequence.camera, white=white, threads=1)
        for index, (time, path) in enumerate(names):
            image = cv2.imread(str(raw / path), cv2.IMREAD_UNCHANGED)
            by_raw.process_raw(image, float(time))
            if index == 0:
                frame = light_field.process(image)
                check((frame.image == first[0]).all() and (frame.sigma == first[1]).all(),
                      "LightField differs from Sequence")
        by_raw.write_trajectory(str(root / "frames.txt"))
        check_same_bytes(root / "frames.txt", root / "raw_vo")

        errors = prism.evaluate(prism.read_trajectory(str(raw / "groundtruth.txt")),
                                by_raw.trajectory)
        check(errors["matched_count"] == FRAMES and errors["ate_rmse_m"] < 0.004, f"{errors}")
        for bad in ((image[:5], 0.0), (image.astype(float), 0.0)):
            try:
                by_raw.process_raw(*bad)
                check(False, "a frame of another size or type is taken")
            except ValueError as error:
                check("image: expected uint8" in str(error), str(error))
        check_example(raw, root / "run.svg")
        print(f"{FRAMES} frames, ATE {errors['ate_rmse_m']:.4f} m, three ways the same bytes")


main()
