"""The floor in a ride: its map, and the speed at which the chair goes where it saw none.

Edges that the chair cannot take are obstacles to all stages. Floor that no sensor has seen, as
behind an obstacle, behind the chair at the beginning, or where it returns nothing, is neither: the
chair is slow enough to stop before it, may creep onto it forwards, where the rider looks, and while
it turns on the spot, and not backwards. Without a sensor that sees the floor nothing is limited.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.messages import Decision, LiveObstacles, Mode
from cohelm.navigation.tick import StepInput
from cohelm.perception import FloorEdges, pose_at
from cohelm.perception.ground.ground_map import GroundMap, known_floor, update_ground
from cohelm.perception.pipeline import MAX_DELAY
from cohelm.reasons import Reason
from cohelm.robots import Robot

CREEPING = 0.2
"""Speed of the outermost wheel on floor that it never saw, m/s (assumed)."""
_REACTION = 0.25
"""Time before the chair brakes, s: a step, a sweep and the drive's lag (assumed)."""
_STILL = 0.01
"""Speed backwards or aside that counts as none, m/s."""
_ALONG = 0.3
"""Speed at which a motion is looked ahead while the chair stands, m/s."""


def update_floor(step: StepInput) -> GroundMap | None:
    """Add the new clouds to the map of the floor; None as long as there was no cloud."""
    setup, observation = step.setup, step.observation
    if not setup.robot.sees_floor:
        return None
    timely = [each for each in observation.clouds if abs(each.time - observation.time) <= MAX_DELAY]
    if not timely:
        return step.memory.floor
    poses = np.array([pose_at(observation, cloud.time) for cloud in timely])
    return update_ground(
        step.memory.floor, tuple(timely), poses, setup.grid, setup.robot, setup.ground
    )


@lru_cache(maxsize=2)
def with_all_edges(live: LiveObstacles, edges: FloorEdges) -> LiveObstacles:
    """Add the edges outside the window of the live obstacles; ``live`` itself if there is none.

    Cached, so that the result is the same object while nothing changes.
    """
    if not len(edges.cells):
        return live
    end = live.corner + live.occupied.shape
    low = np.minimum(live.corner, edges.cells.min(axis=0))
    high = np.maximum(end, edges.cells.max(axis=0) + 1)
    occupied = np.zeros(high - low, dtype=np.uint8)
    (r0, c0), (r1, c1) = live.corner - low, end - low
    occupied[r0:r1, c0:c1] = live.occupied
    rows, cols = (edges.cells - low).T
    occupied[rows, cols] = 1
    return replace(live, corner=low, occupied=occupied)


def with_floor_limit(step: StepInput, floor: GroundMap | None) -> StepInput:
    """Limit the speed so that the chair stops before floor that it never saw, or creeps onto it."""
    if floor is None or _unlimited(step):
        return step
    twist = step.observation.twist if step.commanded is None else step.commanded
    if math.hypot(twist[0], twist[1]) < CREEPING:
        twist = np.array([math.copysign(_ALONG, twist[0]), 0.0, 0.0])
    over = step.request.over_edges
    limit = CREEPING if over else max(_stopping_speed(step, floor, twist), CREEPING)
    if limit >= step.request.speed_limit:
        return step
    return replace(step, request=replace(step.request, speed_limit=limit))


def within_known_floor(decision: Decision, step: StepInput, floor: GroundMap | None) -> Decision:
    """The decision, slowed down where it leads onto floor that was never seen."""
    twist = decision.twist
    if floor is None or _unlimited(step) or not twist.any():
        return decision
    speed = float(_point_speeds(step.setup.robot, twist).max())
    allowed = step.request.over_edges
    limit = CREEPING if allowed else _stopping_speed(step, floor, twist)
    slowed = Reason.EDGES_ALLOWED if allowed else Reason.FLOOR_UNSEEN
    if limit < CREEPING:
        forwards = twist[0] > -_STILL and abs(twist[1]) <= max(twist[0], _STILL)
        known = math.inf if forwards else _stopping_speed(step, floor, twist, seen=False)
        limit = max(limit, min(CREEPING, known))
    if speed <= limit + 1e-9:
        slow = limit <= CREEPING and decision.reason in {None, Reason.OVER_LIMITS}
        return replace(decision, reason=slowed) if slow else decision
    return replace(decision, twist=twist * (limit / speed), reason=slowed)


def _unlimited(step: StepInput) -> bool:
    return step.request.mode is Mode.MANUAL and not step.request.over_edges


def _stopping_speed(
    step: StepInput, floor: GroundMap, twist: Floats, *, seen: bool = True
) -> float:
    """Speed of the outermost wheel along a motion (3,), m/s, from which the chair can stop in time.

    Braking after the reaction ends before the first cell that was never seen; with ``seen`` False,
    before the first on which the chair did not stand either.
    """
    setup = step.setup
    wheels, pose = setup.robot.wheels, step.observation.pose
    distance = known_floor(floor, setup.grid, wheels, pose, twist, seen=seen)
    brake = setup.robot.max_deceleration
    return math.hypot(brake * _REACTION, math.sqrt(2.0 * brake * distance)) - brake * _REACTION


def _point_speeds(robot: Robot, twist: Floats) -> Floats:
    """Speed (k,) of the wheels over the floor under a twist (3,), m/s."""
    x, y = robot.wheels.T
    return np.asarray(np.hypot(twist[0] - twist[2] * y, twist[1] + twist[2] * x))
