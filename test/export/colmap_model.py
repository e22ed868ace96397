# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""A COLMAP text model and its reprojection errors, computed from the files alone."""

import math
import pathlib


def rotate(q, p):
    w, x, y, z = q
    cross = lambda a, b: (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                          a[0] * b[1] - a[1] * b[0])
    t = tuple(2 * c for c in cross((x, y, z), p))
    u = cross((x, y, z), t)
    return tuple(p[i] + w * t[i] + u[i] for i in range(3))


class Model:
    def __init__(self, folder):
        folder = pathlib.Path(folder)
        lines = lambda name: [line for line in (folder / name).read_text().splitlines()
                              if not line.startswith("#")]
        camera = lines("cameras.txt")[0].split()
        assert camera[1] == "PINHOLE", camera
        self.width, self.height = int(camera[2]), int(camera[3])
        self.fx, self.fy, self.cx, self.cy = map(float, camera[4:])
        self.images = {}  # id: (q, t, name, [(x, y, point)])
        text = lines("images.txt")
        for pose, points in zip(text[0::2], text[1::2]):
            words = pose.split()
            seen = list(map(float, points.split()))
            self.images[int(words[0])] = (
                tuple(map(float, words[1:5])), tuple(map(float, words[5:8])), words[9],
                list(zip(seen[0::3], seen[1::3], map(int, seen[2::3]))))
        self.points = {}  # id: (p, error, [(image, index)])
        for line in lines("points3D.txt"):
            words = line.split()
            track = list(map(int, words[8:]))
            self.points[int(words[0])] = (tuple(map(float, words[1:4])), float(words[7]),
                                          list(zip(track[0::2], track[1::2])))

    def project(self, image, p):
        q, t = self.images[image][:2]
        x, y, z = (a + b for a, b in zip(rotate(q, p), t))
        return self.fx * x / z + self.cx, self.fy * y / z + self.cy

    def errors(self):
        """Of every observation, px."""
        errors = []
        for point, (p, _, track) in self.points.items():
            for image, index in track:
                x, y, back = self.images[image][3][index]
                assert back == point, f"image {image} says {back} of point {point}"
                u, v = self.project(image, p)
                errors.append(math.hypot(x - u, y - v))
        return errors
