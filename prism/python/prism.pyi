"""Metric visual odometry for focused plenoptic cameras.

Lengths are in metres, times in seconds; camera frame x right, y down, z forward. Images are arrays of
height x width; the grid of the totally focused image is the camera's (height, width). Bad files raise
InputError, arrays of another shape ValueError.
"""

from typing import Iterator, Optional

import numpy as np
from numpy.typing import NDArray

__version__: str

class InputError(ValueError): ...

class Camera:
    @staticmethod
    def read(path: str, micro_lens_grid: str = "") -> Camera:
        """A camera file (.yaml or CameraModel.xml), and a grid file where that has none."""
    @property
    def focal_length(self) -> float:
        """f_L"""
    @property
    def main_lens_mla_distance(self) -> float:
        """b_L0"""
    @property
    def sensor_mla_distance(self) -> float:
        """B"""
    @property
    def raw_width(self) -> int: ...
    @property
    def raw_height(self) -> int: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def has_micro_lens_grid(self) -> bool: ...
    @property
    def pinhole(self) -> tuple[float, float, float]:
        """Focal length and principal point in px of the pinhole that the focused image is."""
    @property
    def pinhole_z(self) -> float:
        """It stands at (0, 0, pinhole_z) in the camera's frame: in the main lens, or at its front
        focal point, as `prism_vo --focused_image` says."""
    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """n x 3 in the camera's frame to n x (px, px, 1/v); NaN at or inside the focal length."""
    def unproject(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """n x (px, px, 1/v) to n x 3 in the camera's frame; NaN at and beyond infinity."""

class Frame:
    """What the odometry works on; its arrays are views."""
    @property
    def time(self) -> float: ...
    @property
    def image(self) -> NDArray[np.float32]:
        """Totally focused, gray, 0 to 255."""
    @property
    def inverse_virtual_depth(self) -> NDArray[np.float32]:
        """1/v; 0 = no measurement."""
    @property
    def sigma(self) -> NDArray[np.float32]:
        """Standard deviation of 1/v."""

class LightField:
    """Raw frames to frames of the odometry, one at a time."""
    def __init__(self, camera: Camera, white: Optional[NDArray] = None, threads: int = 0) -> None:
        """white: white image; None: micro images are not shaded. threads 0: one a core."""
    def process(self, image: NDArray, time: float = 0.0) -> Frame:
        """uint8 or uint16, raw_height x raw_width (x 3, BGR)."""

class Sequence:
    """A folder as prism_vo opens it: grid refined, white image found, frames read ahead."""
    def __init__(self, folder: str, camera: str = "", micro_lens_grid: str = "", rate_hz: float = 0.0,
                 max_frames: int = 0) -> None: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def format(self) -> str: ...
    @property
    def report(self) -> list[str]:
        """What was found and assumed."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Frame]: ...
    def __next__(self) -> Frame: ...

class FrameResult:
    @property
    def time(self) -> float: ...
    @property
    def status(self) -> str: ...
    @property
    def has_pose(self) -> bool: ...
    @property
    def is_keyframe(self) -> bool: ...
    @property
    def segment(self) -> int: ...
    @property
    def residual_rms(self) -> float: ...
    @property
    def points_used(self) -> int: ...
    @property
    def world_from_cam(self) -> NDArray[np.float64]:
        """4 x 4, as known at this moment."""

class Odometry:
    def __init__(self, camera: Camera, white: Optional[NDArray] = None, threads: int = 2,
                 window_keyframes: int = 8, active_points: int = 2000,
                 focused_image: str = "chief_rays") -> None:
        """Raw frames become images of chief rays, and so do focused ones whose camera says that
        they show virtual points; focused_image="virtual_points" leaves them."""
    def process(self, image: NDArray, inverse_virtual_depth: NDArray, sigma: NDArray,
                time: float) -> FrameResult:
        """A focused frame; 0 in both depth and sigma where nothing was measured."""
    def process_frame(self, frame: Frame) -> FrameResult: ...
    def process_raw(self, image: NDArray, time: float) -> FrameResult:
        """A raw frame; the camera needs its grid, refined before (Sequence does)."""
    @property
    def trajectory(self) -> NDArray[np.float64]:
        """n x (time tx ty tz qx qy qz qw) of world_from_cam, every tracked frame."""
    @property
    def keyframes(self) -> NDArray[np.float64]: ...
    @property
    def points(self) -> tuple[NDArray[np.float64], NDArray[np.uint8], NDArray[np.float64]]:
        """Positions n x 3, colours n x 3, standard deviations along the rays (0: not known)."""
    def write_trajectory(self, path: str) -> None:
        """As prism_vo writes trajectory.txt."""

def read_trajectory(path: str) -> NDArray[np.float64]:
    """TUM or EuRoC."""

def evaluate(groundtruth: NDArray[np.float64],
             estimate: NDArray[np.float64]) -> dict[str, str | float | int]:
    """Errors of a trajectory after alignment, by the names of metrics.json."""
