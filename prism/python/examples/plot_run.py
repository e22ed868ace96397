#!/usr/bin/env python3
# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""plot_run.py SEQUENCE PICTURE: runs the odometry on a folder and plots what it finds.

A walk through the module `prism`; SEQUENCE is what prism_vo takes, with its camera file in the folder,
PICTURE ends in .png, .pdf or .svg.
"""

import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no screen needed
import matplotlib.pyplot as plt
import numpy as np

import prism

folder, picture = sys.argv[1:]

# A folder is opened as prism_vo opens it; `report` says what was found and assumed.
sequence = prism.Sequence(folder)
print("\n".join(sequence.report))

# Frames come one by one; each has a result the moment it is processed.
odometry = prism.Odometry(sequence.camera)
results = [odometry.process_frame(frame) for frame in sequence]
print(f"{sum(r.has_pose for r in results)} of {len(results)} frames tracked")

# Trajectory and points as they are known at the end.
time, x, z = odometry.trajectory[:, [0, 1, 3]].T
positions, colours, sigmas = odometry.points

figure, (above, residuals) = plt.subplots(1, 2, figsize=(11, 5))
above.scatter(positions[:, 0], positions[:, 2], c=colours / 255, s=1)
above.plot(x, z, color="#0072b2", label="camera")
low, high = np.percentile(positions[:, [0, 2]], [2, 98], axis=0)
above.set(title="from above", xlabel="x (m)", ylabel="z (m)", aspect="equal",
          xlim=(min(low[0], x.min()), max(high[0], x.max())),
          ylim=(min(low[1], z.min()), max(high[1], z.max())))
residuals.plot([r.time - time[0] for r in results], [r.residual_rms for r in results])
residuals.set(title="residual RMS", xlabel="time (s)", ylabel="intensities")

groundtruth = pathlib.Path(folder) / "groundtruth.txt"
if groundtruth.exists():
    errors = prism.evaluate(prism.read_trajectory(str(groundtruth)), odometry.trajectory)
    figure.suptitle(f"ATE {1e3 * errors['ate_rmse_m']:.1f} mm, scale {errors['scale']:.4f}")
figure.tight_layout()
figure.savefig(picture)
