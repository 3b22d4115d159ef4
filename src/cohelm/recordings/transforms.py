"""Where frames are in each other, at any time: what tf and odometry say.

A transform is kept as (x, y, z, q_x, q_y, q_z, q_w), as ROS writes it. ``X_AB`` as a 4 × 4 matrix
is the pose of frame B in frame A.
"""

from __future__ import annotations

import array
import math
from collections.abc import Iterator, Sequence

import numpy as np

from cohelm.arrays import Floats

FARTHEST = 1e8
"""m; beyond it nothing on Earth lies, and NaN lies nowhere."""


class Transforms:
    """A forest of frames; each is at home in the frame that was first said to hold it."""

    def __init__(self) -> None:
        self._parent: dict[str, str] = {}
        self._noted: dict[str, array.array[float]] = {}
        self._tracks: dict[str, Floats] = {}

    def note(self, parent: str, child: str, time: float, transform: Sequence[float]) -> None:
        """Note where ``child`` is in ``parent`` at ``time``; −inf: always there.

        Left out is what is no number or turns by nothing, a second parent, and a ring.
        """
        parent, child = name(parent), name(child)
        if math.isnan(time) or not all(abs(number) < FARTHEST for number in transform):
            return
        if not 1e-3 < math.hypot(*transform[3:]) < 1e3 or child in {parent, *self._holders(parent)}:
            return
        if self._parent.setdefault(child, parent) != parent:
            return
        if time == -math.inf or child not in self._noted:
            self._noted[child] = array.array("d")
        self._noted[child].extend((time, *transform))
        self._tracks.pop(child, None)

    @property
    def frames(self) -> tuple[str, ...]:
        """All that were named."""
        return tuple(dict.fromkeys([*self._parent, *self._parent.values()]))

    def held(self, frame: str) -> bool:
        """Whether somebody said where that frame is."""
        return frame in self._parent

    def connected(self, a: str, b: str) -> bool:
        """Whether a chain of transforms leads from one frame to the other."""
        return [a, *self._holders(a)][-1] == [b, *self._holders(b)][-1]

    def at(self, a: str, b: str, time: float) -> Floats:
        """X_AB (4, 4) at ``time``, of two frames that are connected.

        Between two transforms the place is interpolated linearly and the turn along the shorter
        arc; before the first and after the last that one holds.
        """
        shared = {*self._up(a)} & {*self._up(b)}
        return np.linalg.inv(self._along(a, shared, time)) @ self._along(b, shared, time)

    def beyond(self, a: str, b: str, time: float) -> float:
        """By how much ``time`` lies outside of what was said of the chain between them, s."""
        farthest = 0.0
        for child in {*self._up(a)} ^ {*self._up(b)}:
            known = self._track(child)[:, 0]
            if len(known) > 1:
                farthest = max(farthest, known[0] - time, time - known[-1])
        return farthest

    def _up(self, frame: str) -> Iterator[str]:
        """The frame and those that hold it, as far as they are held themselves."""
        while frame in self._parent:
            yield frame
            frame = self._parent[frame]

    def _holders(self, frame: str) -> Iterator[str]:
        return (self._parent[child] for child in self._up(frame))

    def _along(self, frame: str, shared: set[str], time: float) -> Floats:
        """The pose of ``frame`` in the first of its holders that both chains have."""
        total = np.eye(4)
        for child in self._up(frame):
            if child in shared:
                break
            total = matrix(_interpolate(self._track(child), time)) @ total
        return total

    def _track(self, child: str) -> Floats:
        """(k, 8): time and transform with a quaternion of length 1, in the order of time."""
        if child not in self._tracks:
            track = np.array(self._noted[child]).reshape(-1, 8)
            track = track[np.argsort(track[:, 0], kind="stable")]
            track[:, 4:] /= np.linalg.norm(track[:, 4:], axis=1, keepdims=True)
            self._tracks[child] = track
        return self._tracks[child]


def name(frame: str) -> str:
    """A frame's name without the slash that old ones begin with."""
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
    """The transform (7,) at ``time`` between those of a track (k, 8)."""
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
