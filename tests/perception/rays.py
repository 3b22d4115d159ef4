"""A laser of the tests' own: discs and boxes among walls, seen exactly, then noisily."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cohelm.maps import OccupancyGrid, distance_field
from cohelm.messages import Observation, Scan

RANGE = 10.0


def room(width=20.0, height=16.0, resolution=0.05):
    """An empty room about the origin, its walls two cells thick."""
    data = np.zeros((round(height / resolution), round(width / resolution)), dtype=np.int8)
    data[:2], data[-2:], data[:, :2], data[:, -2:] = 100, 100, 100, 100
    return OccupancyGrid(
        data=data, resolution=resolution, X_MG=np.array([-width / 2, -height / 2, 0.0])
    )


def room_walls(grid):
    """The inner faces of the room as segments (4, 4)."""
    x0, y0, x1, y1 = grid.bounds
    e = 2 * grid.resolution
    x0, y0, x1, y1 = x0 + e, y0 + e, x1 - e, y1 - e
    return np.array([[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]])


def box(x, y, side, angle=0.0):
    """The four sides of a square box as segments (4, 4)."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2
    c, s = np.cos(angle), np.sin(angle)
    corners = corners @ np.array([[c, s], [-s, c]]) + [x, y]
    return np.concatenate([corners, np.roll(corners, -1, axis=0)], axis=1)


def cast(origin, angles, segments, discs):
    """Range of every beam (b,), +inf where it meets nothing; segments (k, 4), discs (n, 3)."""
    d = np.stack([np.cos(angles), np.sin(angles)], axis=-1)[:, None]
    ranges = [np.full((len(angles), 1), np.inf)]
    if len(segments):
        a, e = segments[:, :2] - origin, segments[:, 2:] - segments[:, :2]
        det = d[..., 0] * e[:, 1] - d[..., 1] * e[:, 0]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            t = (a[:, 0] * e[:, 1] - a[:, 1] * e[:, 0]) / det
            u = (a[:, 0] * d[..., 1] - a[:, 1] * d[..., 0]) / det
        ranges.append(np.where((t > 0) & (u >= 0) & (u <= 1), t, np.inf))
    if len(discs):
        c = np.asarray(discs)[:, :2] - origin
        along = d[..., 0] * c[:, 0] + d[..., 1] * c[:, 1]
        inside = np.asarray(discs)[:, 2] ** 2 - ((c**2).sum(axis=1) - along**2)
        t = along - np.sqrt(np.maximum(inside, 0.0))
        ranges.append(np.where((inside > 0) & (t > 0), t, np.inf))
    return np.concatenate(ranges, axis=1).min(axis=1)


@dataclass
class Laser:
    """A noisy scanner at the robot's centre that knows nothing of who is who."""

    grid: OccupancyGrid = field(default_factory=room)
    segments: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))
    beams: int = 360
    noise: float = 0.01
    dropout: float = 0.005
    localisation: float = 0.0
    """1: 3 cm and 1° of error at most; slowly wandering."""
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def __post_init__(self):
        self.walls = distance_field(self.grid)
        self.segments = np.concatenate([room_walls(self.grid), self.segments])
        self.wander = np.zeros(3)

    def scan(self, time, pose, discs):
        """(scan, the pose that the localiser tells)."""
        pose = np.asarray(pose, dtype=float)
        step = 2 * np.pi / self.beams
        angles = -np.pi + step * np.arange(self.beams)
        ranges = cast(pose[:2], angles + pose[2], self.segments, np.reshape(discs, (-1, 3)))
        ranges = ranges + self.noise * self.rng.standard_normal(self.beams)
        ranges[ranges > RANGE] = np.inf
        ranges[self.rng.random(self.beams) < self.dropout] = np.nan
        bound = self.localisation * np.array([0.03, 0.03, np.radians(1.0)])
        self.wander = 0.95 * self.wander + 0.15 * bound * self.rng.standard_normal(3)
        told = pose + np.clip(self.wander, -bound, bound)
        scan = Scan(
            time=time,
            mount=np.zeros(3),
            angle_min=-np.pi,
            angle_increment=step,
            range_max=RANGE,
            ranges=ranges,
        )
        return scan, told


def observation(time, pose=(0.0, 0.0, 0.0), **changes):
    """An observation with fresh times."""
    given = {
        "time": time,
        "pose": np.asarray(pose, dtype=float),
        "pose_time": time,
        "twist": np.zeros(3),
        "twist_time": time,
    }
    return Observation(**{**given, **changes})


def ride(laser, where, discs_at, seconds, detector, tracker, start=0.0):
    """Ticks at 20 Hz with scans at 10 Hz: yields (time, people, detections) after each tick."""
    memory = None
    for tick in range(round(seconds * 20)):
        time = start + tick / 20
        detections = ()
        pose = where(time)
        if tick % 2 == 0:
            scan, told = laser.scan(time, pose, discs_at(time))
            detections = (detector.detect(scan, told, laser.walls),)
        people, memory = tracker.track(observation(time, pose), detections, memory)
        yield time, people, detections
