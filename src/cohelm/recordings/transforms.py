"""Transforms between frames over time, from tf and odometry.

A transform is stored as (x, y, z, q_x, q_y, q_z, q_w), as ROS writes it. ``X_AB`` as a 4 × 4 matrix
is the pose of frame B in frame A.
"""

from __future__ import annotations

import array
import math
from collections.abc import Iterator, Sequence

import numpy as np

from cohelm.arrays import Floats

MAX_COORDINATE = 1e8
"""Maximum valid coordinate, m; NaN is invalid, too."""


class Transforms:
    """Forest of frames; the first parent of a frame counts."""

    def __init__(self) -> None:
        self._parent: dict[str, str] = {}
        self._samples: dict[str, array.array[float]] = {}
        self._tracks: dict[str, Floats] = {}

    def add(self, parent: str, child: str, time: float, transform: Sequence[float]) -> None:
        """Add the pose of ``child`` in ``parent`` at ``time``, s; −inf: static.

        Ignored: numbers that are not finite, zero quaternions, a second parent, and cycles.
        """
        parent, child = name(parent), name(child)
        if math.isnan(time) or not all(abs(number) < MAX_COORDINATE for number in transform):
            return
        if not 1e-3 < math.hypot(*transform[3:]) < 1e3 or child in {
            parent,
            *self._ancestors(parent),
        }:
            return
        if self._parent.setdefault(child, parent) != parent:
            return
        if time == -math.inf or child not in self._samples:
            self._samples[child] = array.array("d")
        self._samples[child].extend((time, *transform))
        self._tracks.pop(child, None)

    def shift(self, child: str, seconds: float) -> None:
        """Move the times of the transforms to a frame."""
        samples = self._samples.get(child)
        if samples is not None and seconds:
            for k in range(0, len(samples), 8):
                samples[k] += seconds
            self._tracks.pop(child, None)

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames."""
        return tuple(dict.fromkeys([*self._parent, *self._parent.values()]))

    def has_parent(self, frame: str) -> bool:
        """Check that a transform to that frame was added."""
        return frame in self._parent

    def connected(self, a: str, b: str) -> bool:
        """Check that a chain of transforms connects two frames."""
        return [a, *self._ancestors(a)][-1] == [b, *self._ancestors(b)][-1]

    def at(self, a: str, b: str, time: float) -> Floats:
        """X_AB (4, 4) at ``time``, of two connected frames.

        Between two samples positions are interpolated linearly and rotations along the shorter
        arc; before the first and after the last sample that one holds.
        """
        shared = {*self._up(a)} & {*self._up(b)}
        return np.linalg.inv(self._along(a, shared, time)) @ self._along(b, shared, time)

    def extrapolation(self, a: str, b: str, time: float) -> float:
        """Largest distance of ``time`` from the samples of the chain between two frames, s."""
        farthest = 0.0
        for child in {*self._up(a)} ^ {*self._up(b)}:
            known = self._track(child)[:, 0]
            if len(known) > 1:
                farthest = max(farthest, known[0] - time, time - known[-1])
        return farthest

    def _up(self, frame: str) -> Iterator[str]:
        """The frame and its ancestors that have a parent."""
        while frame in self._parent:
            yield frame
            frame = self._parent[frame]

    def _ancestors(self, frame: str) -> Iterator[str]:
        return (self._parent[child] for child in self._up(frame))

    def _along(self, frame: str, shared: set[str], time: float) -> Floats:
        """Pose of ``frame`` in the first ancestor that both chains share."""
        total = np.eye(4)
        for child in self._up(frame):
            if child in shared:
                break
            total = matrix(_interpolate(self._track(child), time)) @ total
        return total

    def _track(self, child: str) -> Floats:
        """(k, 8): time and transform with a unit quaternion, in the order of time."""
        if child not in self._tracks:
            track = np.array(self._samples[child]).reshape(-1, 8)
            track = track[np.argsort(track[:, 0], kind="stable")]
            track[:, 4:] /= np.linalg.norm(track[:, 4:], axis=1, keepdims=True)
            self._tracks[child] = track
        return self._tracks[child]


def name(frame: str) -> str:
    """Name of a frame without the leading slash of old ones."""
    return frame.lstrip("/")


def planar(X_AB: Floats) -> Floats:
    """(x, y, yaw) of a pose (4, 4)."""
    return np.array([X_AB[0, 3], X_AB[1, 3], math.atan2(X_AB[1, 0], X_AB[0, 0])])


def fixed_axes(X_AB: Floats) -> Floats:
    """(x, y, z, roll, pitch, yaw about the fixed axes) of a pose (4, 4)."""
    R = X_AB[:3, :3]
    pitch = math.atan2(0.0 - R[2, 0], math.hypot(R[2, 1], R[2, 2]))
    roll = math.atan2(R[2, 1], R[2, 2])
    return np.array([*X_AB[:3, 3], roll, pitch, math.atan2(R[1, 0], R[0, 0])])


def matrix(transform: Sequence[float] | Floats) -> Floats:
    """The pose (4, 4) of (x, y, z, q_x, q_y, q_z, q_w), whose quaternion may be of any length."""
    given = np.array(transform, dtype=float)
    x, y, z, w = given[3:] / np.linalg.norm(given[3:])
    out = np.eye(4)
    out[:3, 3] = given[:3]
    out[:3, :3] = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return out


def _interpolate(track: Floats, time: float) -> Floats:
    """Interpolate a track (k, 8) at ``time``; returns the transform (7,)."""
    k = int(np.searchsorted(track[:, 0], time, side="right"))
    if k in {0, len(track)}:
        return np.asarray(track[max(k - 1, 0), 1:])
    a, b = track[k - 1, 1:], track[k, 1:].copy()
    since, until = track[k - 1, 0], track[k, 0]
    share = (time - since) / (until - since) if math.isfinite(since) else 1.0
    cosine = float(a[3:] @ b[3:])
    if cosine < 0.0:
        b[3:] *= -1.0
    angle = math.acos(min(abs(cosine), 1.0))
    out = (1.0 - share) * a + share * b
    if angle > 1e-6:
        out[3:] = math.sin((1.0 - share) * angle) * a[3:] + math.sin(share * angle) * b[3:]
    return out
