"""Dynamic window approach: Fox, Burgard and Thrun (1997), with the critics of Nav2's DWB.

A velocity is admissible if the robot can brake from it before it touches anything. Critics give
each reachable velocity a cost, and the cheapest admissible one is driven.
All critics are computed in one compiled pass.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.polyline import nearest_on_polyline
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.trajectories import braking_trajectory, limited_trajectory
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.kernels import CACHED, callee
from cohelm.maps.distance import sample
from cohelm.messages import LocalPlan, Status
from cohelm.robots.braking import STANDING
from cohelm.robots.capsule import gap_to_disc
from cohelm.robots.wall_contact import WallGrid, circumscribed, wall_gap, wall_grid, wall_margins

AT_REST = 1e-6
"""Inputs up to this do not move the robot, m/s and rad/s."""
_EVERY = 4
"""Steps between the points of a trajectory that are compared with the path."""
_CLOSER = 0.01
"""A gap that is already too small may shrink by this, m."""
_SAFE = 0.01
"""Added to a distance at which contact is impossible, m."""
_TIE = 1e-6
"""Costs with a smaller difference may be a tie."""


class DynamicWindow(NamedTuple):
    """Robot and surroundings for compiled code."""

    current_input: Floats
    """(m,) current input."""
    rise: Floats
    """(m,) largest increase of the inputs within a step."""
    fall: Floats
    """(m,) largest decrease of the inputs within a step."""
    twists: Floats
    """(m, 3) of the unit inputs."""
    start: Floats
    """(3,) pose."""
    steps: int
    step: float
    """s."""
    path: Floats
    """(k, 2), extended beyond the local goal by ``forward_point_distance``; otherwise the critics
    would stop the robot before the goal."""
    capsule: Floats
    discs: Floats
    """Footprint, as in ``Robot``."""
    people: Floats
    """(p, N+1, 2) positions at the times of the trajectories."""
    radius: Floats
    """(p,) m."""
    walls: WallGrid


class DwaWeights(NamedTuple):
    """Margins and weights; see ``Dwa.Parameters``."""

    wall_margin: float
    people_margin: float
    inflation: float
    reaction: float
    deceleration: float
    turn_deceleration: float
    path: float
    path_alignment: float
    goal: float
    goal_alignment: float
    obstacles: float
    changes: float
    forward_point_distance: float


class _Bounds(NamedTuple):
    """Contact gaps, and distances beyond which no critic counts, m."""

    wall_gaps: Floats
    """(c,)."""
    people_gaps: Floats
    """(p,)."""
    wall_range: float
    """Distance of the pose to walls."""
    people_range: float
    """Distance of the pose to people's outlines."""
    free: float
    """Free distance at the start."""


@njit(**CACHED)
def ramp(target: Floats, current_input: Floats, rise: Floats, fall: Floats, inputs: Floats) -> None:
    """Fill ``inputs`` (N, m): from the current input to ``target`` (m,) as fast as limits allow.

    Each input by itself, as in the dynamic window of Fox et al.
    rise, fall: largest change within a step, (m,); half of it in the first one.
    """
    for i in range(inputs.shape[1]):
        before = current_input[i]
        for k in range(inputs.shape[0]):
            share = 0.5 if k == 0 else 1.0
            before = min(max(target[i], before - share * fall[i]), before + share * rise[i])
            inputs[k, i] = before


@njit(**CACHED)
def drive(start: Floats, inputs: Floats, twists: Floats, step: float, poses: Floats) -> None:
    """Fill ``poses`` (N+1, 3) from inputs (N, m); ``twists`` (m, 3) of the unit inputs.

    Each step drives with the heading of its middle: the chord of an arc up to third order.
    """
    poses[0] = start
    for k in range(inputs.shape[0]):
        vx, vy, w = 0.0, 0.0, 0.0
        for i in range(inputs.shape[1]):
            vx += inputs[k, i] * twists[i, 0]
            vy += inputs[k, i] * twists[i, 1]
            w += inputs[k, i] * twists[i, 2]
        heading = poses[k, 2] + 0.5 * step * w
        cos, sin = math.cos(heading), math.sin(heading)
        poses[k + 1, 0] = poses[k, 0] + step * (cos * vx - sin * vy)
        poses[k + 1, 1] = poses[k, 1] + step * (sin * vx + cos * vy)
        poses[k + 1, 2] = poses[k, 2] + step * w


@njit(**CACHED)
def velocity_costs(
    targets: Floats, window: DynamicWindow, weights: DwaWeights, last: Floats
) -> Floats:
    """Cost (a,) of each sampled velocity; +inf: not admissible, or not the minimum.

    No critic has a negative cost, so a velocity is abandoned as soon as it costs more than another
    one that moves. Velocities near the last one come first.

    Args:
        targets: (a, m) sampled inputs.
        window: robot and surroundings.
        weights: of the critics.
        last: the inputs chosen before, (m,).
    """
    out = np.full(targets.shape[0], np.inf)
    inputs = np.empty((window.steps, targets.shape[1]))
    poses = np.empty((window.steps + 1, 3))
    bounds = _bounds(window, weights)
    change = np.abs(targets - last).sum(axis=1)
    bound = np.inf
    for a in np.argsort(change):
        ramp(targets[a], window.current_input, window.rise, window.fall, inputs)
        drive(window.start, inputs, window.twists, window.step, poses)
        safe, first_contact, proximity = _obstacles(poses, window, weights, bounds)
        if not safe:
            continue
        out[a] = _path_and_goal(poses, window, weights, first_contact, proximity, change[a], bound)
        if np.abs(targets[a]).max() > AT_REST:
            bound = min(bound, out[a] + _TIE)
    return out


@callee()
def _bounds(window: DynamicWindow, weights: DwaWeights) -> _Bounds:
    start, walls = window.start, window.walls
    wall_gaps = wall_margins(window.discs, start, walls, weights.wall_margin)
    around = circumscribed(window.discs)
    people_gaps = np.empty(window.people.shape[0])
    for i in range(window.people.shape[0]):
        x, y = window.people[i, 0, 0], window.people[i, 0, 1]
        gap = gap_to_disc(window.capsule, start, x, y, window.radius[i])
        people_gaps[i] = min(weights.people_margin, gap - _CLOSER)
    wall_range = around + max(weights.wall_margin, weights.inflation) + 2.0 * walls.resolution
    people_range = around + max(weights.people_margin, weights.inflation) + _SAFE
    free = sample(walls.distance, walls.resolution, walls.X_MG, start[0], start[1])[0] - wall_range
    return _Bounds(wall_gaps, people_gaps, wall_range, people_range, free)


@callee()
def _obstacles(
    poses: Floats, window: DynamicWindow, weights: DwaWeights, bounds: _Bounds
) -> tuple[bool, int, float]:
    """(admissible, step of the first contact or N+1, sum of the obstacle critic) of a trajectory.

    Fox et al., eq. (14): a velocity is admissible if v ≤ √(2 · dist · braking), for turns likewise.
    """
    steps, step, walls = window.steps, window.step, window.walls
    held = min(max(round(weights.reaction / step), 1), steps)
    speed = (
        math.hypot(poses[held, 0] - poses[held - 1, 0], poses[held, 1] - poses[held - 1, 1]) / step
    )
    turn = abs(poses[held, 2] - poses[held - 1, 2]) / step
    distance, angle, proximity, free = 0.0, 0.0, 0.0, bounds.free
    safe, first_contact = True, steps + 1
    for k in range(1, steps + 1):
        moved = math.hypot(poses[k, 0] - poses[k - 1, 0], poses[k, 1] - poses[k - 1, 1])
        turned = abs(poses[k, 2] - poses[k - 1, 2])
        if k > held:
            distance, angle = distance + moved, angle + turned
        nearest, touches = np.inf, False
        # walls: contact must come after the braking distance
        free -= moved
        if free <= 0.0:
            x, y = poses[k, 0], poses[k, 1]
            free = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - bounds.wall_range
        for j in range(window.discs.shape[0] if free <= 0.0 else 0):
            gap = wall_gap(window.discs[j], poses[k], walls)
            nearest = min(nearest, gap)
            touches |= gap < bounds.wall_gaps[j]
        if touches:
            far_enough = distance >= 0.5 * speed * speed / weights.deceleration
            turned_enough = angle >= 0.5 * turn * turn / weights.turn_deceleration
            safe = far_enough and (speed > STANDING or turned_enough)
        # people: contact must come after the braking time
        for i in range(window.people.shape[0]):
            x, y = window.people[i, k, 0], window.people[i, k, 1]
            dx, dy = x - poses[k, 0], y - poses[k, 1]
            if dx * dx + dy * dy > (bounds.people_range + window.radius[i]) ** 2:
                continue
            gap = gap_to_disc(window.capsule, poses[k], x, y, window.radius[i])
            nearest = min(nearest, gap)
            if gap < bounds.people_gaps[i] and moved + turned > STANDING * step:
                touches = True
                safe &= k * step >= weights.reaction + speed / weights.deceleration
        missing = max(1.0 - max(nearest, 0.0) / weights.inflation, 0.0)
        proximity += missing * missing
        if touches:
            proximity += steps - k
            first_contact = k
            break
    return safe, first_contact, proximity


@callee()
def _path_and_goal(
    poses: Floats,
    window: DynamicWindow,
    weights: DwaWeights,
    first_contact: int,
    proximity: float,
    change: float,
    bound: float,
) -> float:
    """Cost of an admissible trajectory up to its first contact; +inf if it is above ``bound``."""
    steps, path = window.steps, window.path
    goal = path[path.shape[0] - 1]
    # cheap critics first
    end = poses[min(first_contact, steps)]
    x = end[0] + weights.forward_point_distance * math.cos(end[2])
    y = end[1] + weights.forward_point_distance * math.sin(end[2])
    goal_offset = math.hypot(x - goal[0], y - goal[1])
    partial_cost = (
        weights.goal_alignment * goal_offset
        + weights.obstacles * proximity / steps
        + weights.changes * change
    )
    if partial_cost > bound:
        return np.inf
    remaining = nearest_on_polyline(path, end[0], end[1]).remaining
    remaining = abs(remaining - weights.forward_point_distance)
    if partial_cost + weights.goal * remaining > bound:
        return np.inf
    # mean distance from the path
    path_offset, points = 0.0, 0
    for k in range(1, first_contact):
        if k % _EVERY == 0 or k == steps:
            path_offset += nearest_on_polyline(path, poses[k, 0], poses[k, 1]).distance
            points += 1
    return float(
        weights.path * path_offset / max(points, 1)
        + weights.path_alignment * nearest_on_polyline(path, x, y).distance
        + weights.goal * remaining
        + weights.goal_alignment * goal_offset
        + weights.obstacles * proximity / steps
        + weights.changes * change
    )


_STOPPED = 0.02
"""A reference that is always slower than this needs no motion, m/s."""
_CREEP = 0.1
"""Speeds up to this are sampled even where the reference stands, m/s."""


class Dwa:
    """Samples velocities, simulates each, and drives the cheapest admissible one.

    The path is the reference over ``steps``, its end the local goal. If only standing is
    admissible, the robot brakes with a reason. It simulates one constant velocity at a time.
    """

    class Parameters(Model):
        """Horizon, samples, margins and critic weights; assumed unless a source is named."""

        steps: int = Field(30, ge=3, le=100)
        """Steps of the reference that is the path."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s."""
        horizon: float = Field(1.7, gt=0.1, le=6.0)
        """Simulated time of each velocity, s (DWB's ``sim_time``)."""
        speeds: int = Field(15, ge=2, le=60)
        """Samples of the speed (DWB has 20)."""
        turns: int = Field(25, ge=3, le=99)
        """Samples of the turn rate (DWB has 20)."""
        predict: bool = True
        """People move as predicted; off, they stay at their present positions, as in a costmap."""
        reaction: float = Field(0.2, ge=0.0, le=1.0)
        """Time for which a velocity acts before braking can begin, s."""
        wall_margin: float = Field(0.04, ge=0.0, le=0.5)
        """Gap to a wall that counts as contact, m."""
        people_margin: float = Field(0.2, ge=0.0, le=1.0)
        """Gap to a person that counts as contact, m."""
        inflation: float = Field(0.5, gt=0.0, le=3.0)
        """Gap below which the obstacle critic counts, m (DWB: that of the inflation layer)."""
        forward_point_distance: float = Field(0.325, gt=0.0, le=2.0)
        """Distance of the aligned point ahead of the robot, m (DWB's name)."""
        path: float = Field(0.8, ge=0.0)
        """Weight of the mean distance from the path, 1/m (PathDist)."""
        path_alignment: float = Field(0.8, ge=0.0)
        """Weight of the distance of the point ahead from the path, 1/m (PathAlign)."""
        goal: float = Field(1.0, ge=0.0)
        """Weight of the remaining distance to the local goal, 1/m (GoalDist)."""
        goal_alignment: float = Field(0.4, ge=0.0)
        """Weight of the distance of the point ahead from the local goal, 1/m (GoalAlign)."""
        obstacles: float = Field(0.6, ge=0.0)
        """Weight of the squared missing share of ``inflation``, mean over time (BaseObstacle)."""
        changes: float = Field(0.02, ge=0.0)
        """Weight of a change of the velocity, s/m (replaces Oscillation)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self._simulated = min(max(round(p.horizon / p.step), 2), p.steps)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem, self.steps)
        problem = problem.truncated(self.steps)
        current_input = estimate_current_input(problem, previous)
        samples = self._samples(problem, current_input)
        costs = self._costs(problem, current_input, samples, previous)
        moving = np.abs(samples).max(axis=1) > AT_REST
        must_move = bool(problem.reference.speeds.max() > _STOPPED)
        if not np.isfinite(costs).any() or (must_move and not np.isfinite(costs[moving]).any()):
            rest = braking_trajectory(problem, current_input, self._simulated)
            return plan_of(problem, rest, Status.STOP, costs={})
        # the first of all equal costs, so that a rotation of the world changes nothing
        lowest = float(costs.min())
        best = int(np.argmax(costs <= lowest + 1e-9))
        trajectory = self._driven(problem, current_input, samples[best])
        return plan_of(
            problem, trajectory, Status.OK, costs={"critics": lowest}, memory=trajectory.inputs[-1]
        )

    def _samples(self, problem: LocalProblem, current_input: Floats) -> Floats:
        """Inputs (a, m) within the limits that can be reached within the horizon."""
        p = self.parameters
        low, high, rise, fall = problem.input_bounds()
        fastest = max(float(problem.reference.speeds.max()), _CREEP)
        high[0] = min(high[0], fastest)
        low, high = (
            np.maximum(low, current_input - fall * p.horizon),
            np.minimum(high, current_input + rise * p.horizon),
        )
        high = np.maximum(high, low)
        counts = [p.speeds, *[max(p.speeds // 2, 3)] * (len(current_input) - 2), p.turns]
        axes = [_spread(low[i], high[i], counts[i]) for i in range(len(current_input))]
        samples = np.array(list(itertools.product(*axes)))
        speed = np.hypot(*problem.robot.motion_model.twist(samples)[:, :2].T)
        limit = max(high[0], float(np.hypot(*problem.twist[:2])))
        allowed: Floats = samples[speed <= limit + 1e-9]
        return allowed

    def _costs(
        self,
        problem: LocalProblem,
        current_input: Floats,
        samples: Floats,
        previous: LocalPlan | None,
    ) -> Floats:
        p, robot = self.parameters, problem.robot
        _, _, rise, fall = problem.input_bounds()
        memory = previous.memory if previous is not None else None
        last = (
            memory
            if isinstance(memory, np.ndarray) and memory.shape == current_input.shape
            else current_input
        )
        window = DynamicWindow(
            current_input=current_input,
            rise=rise * p.step,
            fall=fall * p.step,
            twists=robot.motion_model.twist(np.eye(len(current_input))),
            start=problem.pose,
            steps=self._simulated,
            step=p.step,
            path=_extended(problem.reference.poses, p.forward_point_distance),
            capsule=robot.capsule,
            discs=robot.discs,
            people=self._people(problem),
            radius=np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
            walls=wall_grid(problem.walls),
        )
        braking = {
            "deceleration": robot.max_deceleration,
            "turn_deceleration": robot.max_turn_acceleration,
        }
        same = {name: getattr(p, name) for name in DwaWeights._fields if name not in braking}
        weights = DwaWeights(**same, **braking)
        costs: Floats = velocity_costs(samples, window, weights, last)
        return costs

    def _people(self, problem: LocalProblem) -> Floats:
        """Positions of people at the simulated times, (n·h, N+1, 2); every hypothesis counts."""
        mean = problem.predictions.mean[:, :, : self._simulated + 1]
        if not self.parameters.predict:
            mean = np.repeat(mean[:, :, :1], self._simulated + 1, axis=2)
        return np.ascontiguousarray(mean).reshape(-1, self._simulated + 1, 2)

    def _driven(self, problem: LocalProblem, current_input: Floats, target: Floats) -> Trajectory:
        _, _, rise, fall = problem.input_bounds()
        inputs = np.empty((self._simulated, len(current_input)))
        ramp(target, current_input, rise * self.step, fall * self.step, inputs)
        return limited_trajectory(problem, inputs, current_input)


def _extended(poses: Floats, distance: float) -> Floats:
    """The path (k + 1, 2) of reference poses (k, 3), extended straight beyond its end."""
    heading = poses[-1, 2]
    beyond = poses[-1, :2] + distance * np.array([np.cos(heading), np.sin(heading)])
    return np.concatenate([poses[:, :2], beyond[None]])


def _spread(low: float, high: float, count: int) -> Floats:
    """Even samples from low to high, and 0 if it lies between them."""
    values = np.linspace(low, high, count)
    return np.union1d(values, [0.0]) if low < 0.0 < high else values
