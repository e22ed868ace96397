# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""read_back_test.py FORMAT WRITE_SAMPLE_EXPORTS: an exported run read by tools of its ecosystem.

Exit status 77 (skipped) where the tool is not installed and nothing else could be checked.
"""

import json
import math
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

import colmap_model
import mcap_records

HERE = pathlib.Path(__file__).parent
KEYFRAMES = 6
POSES = 12


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def read_ply(path):
    data = path.read_bytes()
    header, body = data.split(b"end_header\n", 1)
    names = re.findall(rb"property (float|uchar) (\w+)", header)
    count = int(re.search(rb"element vertex (\d+)", header).group(1))
    format = "<" + "".join("f" if kind == b"float" else "B" for kind, _ in names)
    check(len(body) == count * struct.calcsize(format), f"{path}: {len(body)} bytes")
    names = [name.decode() for _, name in names]
    return [dict(zip(names, values)) for values in struct.iter_unpack(format, body)]


def check_colmap(folder):
    model = colmap_model.Model(folder / "colmap")
    check(len(model.images) == KEYFRAMES, f"{len(model.images)} images")
    for _, _, name, _ in model.images.values():
        check((folder / "colmap/images" / name).is_file(), f"no image {name}")
    measured = model.errors()
    check(len(measured) > 4 * len(model.points), f"{len(measured)} observations")
    mean = sum(measured) / len(measured)
    print(f"{len(model.points)} points, {len(measured)} observations, {mean:.3f} px")
    check(mean < 0.08, f"mean reprojection error of {mean:.3f} px")
    if shutil.which("colmap") is None:
        print("colmap is not installed: only read here (tools/install_deps.sh --with-readers)")
        return
    run = subprocess.run(["colmap", "model_analyzer", "--path", str(folder / "colmap")],
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=True)
    figure = lambda name: float(re.search(name + r": ([\d.]+)", run.stdout).group(1))
    check(figure("Registered images") == KEYFRAMES, run.stdout)
    check(figure("Points") == len(model.points), run.stdout)
    check(figure("Observations") == len(measured), run.stdout)
    check(abs(figure("Mean reprojection error") - mean) < 0.03, run.stdout)
    print("colmap model_analyzer agrees")


def check_nerfstudio(folder):
    folder = folder / "nerfstudio"
    transforms = json.loads((folder / "transforms.json").read_text())
    check(len(transforms["frames"]) == KEYFRAMES, "frames are missing")
    points = read_ply(folder / transforms["ply_file_path"])
    # The points of the wall, seen by each camera as OpenGL does: inside the picture, where the
    # depth image has their depth.
    import cv2
    for frame in transforms["frames"]:
        image = cv2.imread(str(folder / frame["file_path"]))
        depth = cv2.imread(str(folder / frame["depth_file_path"]), cv2.IMREAD_UNCHANGED)
        check(image.shape[:2] == (transforms["h"], transforms["w"]), "image of another size")
        m = frame["transform_matrix"]
        seen = 0
        for p in points:
            d = [p[axis] - m[i][3] for i, axis in enumerate("xyz")]
            x, y, z = (sum(m[i][k] * d[i] for i in range(3)) for k in range(3))
            check(z < 0, "a point behind the camera")
            u = transforms["fl_x"] * x / -z + transforms["cx"]
            v = -transforms["fl_y"] * y / -z + transforms["cy"]
            if not (0 <= u < transforms["w"] and 0 <= v < transforms["h"]):
                continue
            seen += 1
            check(abs(1e-3 * depth[int(v), int(u)] + z) < 0.02, f"depth {-z} at {u}, {v}")
        check(seen > 100, f"{seen} points seen")


def check_trajectories(folder):
    kitti = [list(map(float, line.split()))
             for line in (folder / "trajectory_kitti.txt").read_text().splitlines()]
    times = (folder / "trajectory_kitti_times.txt").read_text().split()
    lines = (folder / "trajectory_euroc.csv").read_text().splitlines()
    check(lines[0].startswith("#timestamp"), lines[0])
    euroc = [line.split(",") for line in lines[1:]]
    check(len(kitti) == len(times) == len(euroc) == POSES, "poses are missing")
    for matrix, time, row in zip(kitti, times, euroc):
        check(time.replace(".", "") == row[0], f"time {time} and {row[0]}")
        check(all(abs(matrix[4 * i + 3] - float(row[1 + i])) < 1e-7 for i in range(3)), row)
        w, x, y, z = map(float, row[4:])
        check(abs(matrix[1] - 2 * (x * y - w * z)) < 1e-7, row)
    try:
        from evo.tools import file_interface
    except ImportError:
        print("evo is not installed: only read here")
        return
    check(file_interface.read_kitti_poses_file(folder / "trajectory_kitti.txt").num_poses == POSES,
          "evo reads other poses")
    check(file_interface.read_euroc_csv_trajectory(
        folder / "trajectory_euroc.csv").num_poses == POSES, "evo reads other poses")
    print("evo reads both")


def check_mcap(folder):
    path = folder / "run.mcap"
    counts = mcap_records.check_file(path.read_bytes())
    expected = {"/tf": 2 * POSES, "/image": KEYFRAMES, "/calibration": KEYFRAMES, "/points": 1}
    check(counts == expected, f"{counts}")
    if shutil.which("node") is None or not (HERE / "node_modules/@mcap/core").is_dir():
        print("@mcap/core is not installed: only read here (tools/install_deps.sh --with-readers)")
        return
    run = subprocess.run(["node", str(HERE / "read_mcap.mjs"), str(path)], check=True,
                         stdout=subprocess.PIPE, text=True)
    read = json.loads(run.stdout)
    check(read["counts"] == expected, f"@mcap/core reads {read['counts']}")
    check(read["schemas"] == {
        "/tf": "foxglove.FrameTransform", "/image": "foxglove.CompressedImage",
        "/calibration": "foxglove.CameraCalibration", "/points": "foxglove.PointCloud"},
        f"{read['schemas']}")
    line = (folder / "trajectory_euroc.csv").read_text().splitlines()[-1].split(",")
    check(read["last_time"] == line[0], f"{read['last_time']}")
    check(all(abs(read["last_position"][axis] - float(line[1 + i])) < 1e-8
              for i, axis in enumerate("xyz")), f"{read['last_position']}")
    points = read_ply(folder / "points_oriented.ply")
    check(read["points"] == len(points), f"{read['points']} points")
    check(all(abs(read["first_point"][i] - points[0]["xyz"[i]]) < 1e-6 for i in range(3)),
          f"{read['first_point']}")
    check(read["png"] and abs(read["K"][0] - 400) < 1e-9, f"{read['K']}")
    print("@mcap/core reads every message")


def check_ply(folder):
    for name, least in (("points_oriented.ply", 300), ("points_dense.ply", 50000)):
        points = read_ply(folder / name)
        check(len(points) >= least, f"{name}: {len(points)} points")
        for p in points[::17]:
            check(abs(p["z"] - 1.5) < 0.01, f"{name}: {p}")
            check(abs(math.hypot(p["nx"], p["ny"], p["nz"]) - 1) < 1e-4, f"{name}: {p}")
            check(0 < p["sigma"] < 0.1, f"{name}: {p}")
    try:
        import open3d
    except ImportError:
        print("open3d is not installed: only read here")
        return
    cloud = open3d.io.read_point_cloud(str(folder / "points_dense.ply"))
    check(cloud.has_normals() and cloud.has_colors(), "open3d finds no normals or colours")


def main():
    kind, program = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, folder], check=True, stdout=subprocess.DEVNULL)
        globals()["check_" + kind](pathlib.Path(folder))


if __name__ == "__main__":
    try:
        main()
    except ImportError as error:
        print(f"skipped: {error}")
        sys.exit(77)
