"""Agreement of pose and odometry over windows of time."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import between, wrap_angle
from cohelm.health.parameters import HealthParameters
from cohelm.messages import Observation
from cohelm.robots import move

_MAX_GAP = 0.5
"""Time between two observations after which the dead reckoning begins anew, s."""
_COARSE_GAP = 0.2
"""Time between two observations after which the comparison begins anew, s: how the chair moved
meanwhile is not known well enough for it."""
JUMP = (0.25, 0.35)
"""Step of the pose beyond the odometry that is a jump, m and rad; the defaults of the safety gate,
whose parameters it does not follow."""


class MotionHistory(NamedTuple):
    """Past of pose and odometry."""

    rows: Floats
    """(k, 7): time, pose, dead-reckoned pose; oldest first."""
    twist: Floats
    """Odometry (3,) of the newest row."""
    jumped: float = -math.inf
    """Time of the last jump, s."""

    @property
    def odometry(self) -> Floats:
        """Dead-reckoned pose (3,) now."""
        return self.rows[-1, 4:]


def update_motion(
    memory: MotionHistory | None, observation: Observation, p: HealthParameters
) -> MotionHistory:
    """Add an observation; a jump of the pose or a gap begins anew."""
    now, pose = observation.time, observation.pose
    if memory is None or not 0.0 <= now - memory.rows[-1, 0] <= _MAX_GAP:
        jumped = -math.inf if memory is None else memory.jumped
        return MotionHistory(np.array([[now, *pose, *pose]]), observation.twist, jumped)
    if now == memory.rows[-1, 0]:
        return memory
    last = memory.rows[-1]
    # Mean speeds: where a slow computer sees few observations, the newest speed alone is wrong by
    # as much as a fault of the odometry.
    odometry = move(last[4:], 0.5 * (memory.twist + observation.twist), now - last[0])
    step = difference(between(last[1:4], pose), between(last[4:], odometry))
    if step[0] > JUMP[0] or step[1] > JUMP[1]:
        return MotionHistory(np.array([[now, *pose, *pose]]), observation.twist, now)
    row = np.array([[now, *pose, *odometry]])
    if now - last[0] > _COARSE_GAP:
        return MotionHistory(row, observation.twist, memory.jumped)
    keep = memory.rows[:, 0] >= now - p.long_window - 1e-9
    rows = np.concatenate([memory.rows[keep], row])
    return MotionHistory(rows, observation.twist, memory.jumped)


def disagreement(history: MotionHistory, p: HealthParameters) -> float:
    """Difference of the motions of pose and odometry, 1 where it is a contradiction."""
    now, worst = history.rows[-1], 0.0
    windows = ((p.short_window, p.short_difference), (p.long_window, p.long_difference))
    for window, allowed in windows:
        i = int(np.searchsorted(history.rows[:, 0], now[0] - window - 1e-9))
        then = history.rows[min(i, len(history.rows) - 1)]
        by_pose = between(then[1:4], now[1:4])
        by_wheels = between(then[4:], now[4:])
        worst = max(worst, ratio(by_pose, by_wheels, allowed, p.turn_difference))
    return worst


def difference(one: Floats, other: Floats) -> tuple[float, float]:
    """Differences of two motions (3,), m and rad."""
    turn = abs(float(wrap_angle(one[2] - other[2])))
    return math.hypot(one[0] - other[0], one[1] - other[1]), turn


def ratio(
    one: Floats, other: Floats, allowed: tuple[float, float], turns: tuple[float, float]
) -> float:
    """Difference of two motions (3,) as a share of what is allowed.

    Args:
        one, other: motions.
        allowed: m, and share of the longer distance.
        turns: rad, and share of the larger turn.
    """
    apart, turned = difference(one, other)
    far = max(math.hypot(one[0], one[1]), math.hypot(other[0], other[1]))
    turn = max(abs(one[2]), abs(other[2]))
    share: float = max(
        apart / (allowed[0] + allowed[1] * far + 0.3 * turns[0] * far),
        turned / (turns[0] + turns[1] * turn),
    )
    return share
