"""Latest transforms between frames, as a localiser, odometry and the robot's description say."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Floats
from cohelm.recordings.transforms import MAX_COORDINATE, matrix, name


@dataclass(frozen=True, slots=True)
class Link:
    """Transform from a frame to its parent."""

    parent: str
    X_PC: Floats
    """(4, 4) pose of the child in the parent."""
    time: float
    """Stamp, s; −inf: static."""
    arrival: float
    """Time at which it arrived, s."""


class FrameTree:
    """Latest link of every frame; memory grows with the number of frames only."""

    def __init__(self) -> None:
        self._links: dict[str, Link] = {}

    def add(
        self,
        parent: str,
        child: str,
        transform: tuple[float, ...],
        *,
        time: float,
        arrival: float,
    ) -> bool:
        """Add the pose (x, y, z, q_x, q_y, q_z, q_w) of ``child`` in ``parent``.

        Returns:
            False if it was ignored: a number that is not finite, a zero quaternion, or a cycle.
        """
        parent, child = name(parent), name(child)
        finite = all(math.isfinite(n) and abs(n) < MAX_COORDINATE for n in transform)
        if not finite or math.isnan(time) or not 1e-3 < math.hypot(*transform[3:]) < 1e3:
            return False
        if child in {parent, *self._ancestors(parent)}:
            return False
        self._links[child] = Link(parent, matrix(transform), time, arrival)
        return True

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames."""
        parents = [link.parent for link in self._links.values()]
        return tuple(dict.fromkeys([*self._links, *parents]))

    def link(self, child: str) -> Link | None:
        """Return the latest link of a frame; None: it has no parent."""
        return self._links.get(name(child))

    def connected(self, a: str, b: str) -> bool:
        """Check that a chain of transforms connects two frames."""
        roots = [[name(each), *self._ancestors(name(each))][-1] for each in (a, b)]
        return roots[0] == roots[1]

    def pose(self, a: str, b: str) -> Floats | None:
        """Return X_AB (4, 4) from the latest links; None: the frames are not connected."""
        if name(a) == name(b):
            return np.eye(4)
        if not self.connected(a, b):
            return None
        out: Floats = np.linalg.inv(self._from_root(name(a))) @ self._from_root(name(b))
        return out

    def _from_root(self, frame: str) -> Floats:
        total = np.eye(4)
        for link in self._chain(frame):
            total = link.X_PC @ total
        return total

    def _chain(self, frame: str) -> Iterator[Link]:
        while frame in self._links:
            link = self._links[frame]
            yield link
            frame = link.parent

    def _ancestors(self, frame: str) -> list[str]:
        return [link.parent for link in self._chain(frame)]
