"""The timed elastic band of Rösmann et al. (2012, 2017): poses and the times between them at once.

A band of poses from the robot to the local goal is pulled taut in time and pushed away by what is
near: one sparse least-squares problem. Bands that pass a person on either side are kept beside one
another, and the cheapest is driven.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.baselines.teb_band import optimise
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.usable import usable
from cohelm.control.verification import brought_to_rest
from cohelm.control.warm_start import followed, last_input
from cohelm.messages import LocalPlan, Status
from cohelm.robots.contact import first_contact

_STALE = 0.5
"""A band older than this is begun anew, s."""
_FEWEST = 4
_REACH = 0.5
"""Gap from a person at which a band is in the way, m."""
_SIDES = (1.0, -1.0)
"""Left of the person in the way, right of it."""
_NAMES = {0.0: "drawn", 1.0: "left", -1.0: "right"}


@value
class Band:
    """What one call leaves to the next."""

    time: float
    """When it was made, s."""
    rows: Annotated[Floats, Shape("n 4")]
    """(x, y, θ, time to the next pose)."""
    side: float
    """On which side of whom is in the way it passes: 1 left, −1 right, 0 as drawn."""
    other: Annotated[Floats, Shape("k 4")]
    """The band on the other side, to be gone on with; empty: there is none."""


class Teb:
    """Optimises a band, drives its beginning, and stops where that would touch something."""

    class Parameters(Model):
        """Horizon, budget, margins and weights; after ``teb_local_planner`` unless assumed."""

        steps: int = Field(30, ge=3, le=100)
        """Steps of the reference whose end is the local goal (assumed)."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s (assumed)."""
        interval: float = Field(0.2, gt=0.05, le=1.0)
        """Wanted time between poses, s (``dt_ref``; 0.3 there)."""
        tolerance: float = Field(0.06, gt=0.0, le=0.5)
        """By which it may differ, s (``dt_hysteresis``)."""
        outer: int = Field(2, ge=1, le=10)
        """Rounds, the band fitted with poses in each (4 there)."""
        inner: int = Field(7, ge=1, le=40)
        """Steps of the solver in each round, those included that are not taken (5 there)."""
        classes: int = Field(3, ge=1, le=3)
        """Bands that are kept: as drawn; left of who is in the way; right too."""
        stays: float = Field(0.9, gt=0.0, le=1.0)
        """Another side is taken only where its cost is below this share of the present one's
        (``selection_cost_hysteresis``)."""
        wall_gap: float = Field(0.1, ge=0.0, le=1.0)
        """Least gap to walls, m (``min_obstacle_dist``, less the robot; assumed)."""
        people_gap: float = Field(0.35, ge=0.0, le=2.0)
        """Least gap to people, m (assumed)."""
        inflation: float = Field(0.4, ge=0.0, le=2.0)
        """Gap beyond these that is still paid for, m (``inflation_dist``)."""
        margin: float = Field(0.05, ge=0.0, lt=0.5)
        """Share of the speed limits that is kept back (``penalty_epsilon``)."""
        time: float = Field(0.4, gt=0.0)
        """Weight of the whole time, 1/s (``weight_optimaltime``, there of squared intervals)."""
        kinematics: float = Field(1000.0, ge=0.0)
        """Of sliding sideways (``weight_kinematics_nh``)."""
        speed: float = Field(2.0, ge=0.0)
        """Of exceeding speeds (``weight_max_vel_x``)."""
        acceleration: float = Field(1.0, ge=0.0)
        """Of exceeding accelerations (``weight_acc_lim_x``)."""
        obstacles: float = Field(50.0, ge=0.0)
        """Of gaps too small (``weight_obstacle``)."""
        near: float = Field(0.3, ge=0.0)
        """Of gaps within the inflation (``weight_inflation``; 0.1 there)."""
        path: float = Field(0.3, ge=0.0)
        """Of the distance from the path (``weight_viapoint``, points all along)."""
        goal: float = Field(20.0, ge=0.0)
        """Of the distance from the local goal, which there is fixed; here somebody may stand on it.
        """
        growth: float = Field(2.0, ge=1.0, le=10.0)
        """Of the weight of obstacles from round to round (``weight_adapt_factor``)."""
        checked: float = Field(0.8, gt=0.0, le=5.0)
        """How far ahead the band must touch nothing, s (``feasibility_check_no_poses``)."""
        wall_margin: float = Field(0.03, ge=0.0)
        """Gap to walls that is a touch there, m (assumed)."""
        people_margin: float = Field(0.15, ge=0.0)
        """Gap to people that is a touch there, m (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        problem = usable(problem, self.steps)
        now = last_input(problem, previous)
        memory = previous.memory if previous is not None else None
        old = memory if isinstance(memory, Band) else None
        band, cost = self._cheapest(problem, now, old)
        motion = self._free(problem, self._driven(problem, now, band.rows))
        if motion is None:
            rows, cost = self._optimised(problem, now, _drawn(problem, self.parameters.interval))
            band = self._band(problem, rows, 0.0)
            motion = self._free(problem, self._driven(problem, now, rows))
        if motion is None:
            rest = brought_to_rest(problem, now, self.steps)
            return _as_plan(problem, rest, None, math.inf)
        return _as_plan(problem, motion, band, cost)

    def _cheapest(self, problem: LocalProblem, now: Floats, old: Band | None) -> tuple[Band, float]:
        """The cheapest band of all sides; the present side is left only for a clear gain."""
        found = []
        for k, (rows, side) in enumerate(self._seeds(problem, old)):
            better, cost = self._optimised(problem, now, rows)
            found.append((cost * (self.parameters.stays if k == 0 else 1.0), cost, better, side))
        found.sort(key=lambda each: each[0])
        _, cost, rows, side = found[0]
        others = [rows for *_, rows, other in found[1:] if other == -side != 0.0]
        return self._band(problem, rows, side, others), cost

    @staticmethod
    def _band(
        problem: LocalProblem, rows: Floats, side: float, others: Sequence[Floats] = ()
    ) -> Band:
        return Band(
            time=problem.time,
            rows=rows,
            side=side,
            other=others[0] if others else np.empty((0, 4)),
        )

    def _seeds(self, problem: LocalProblem, old: Band | None) -> list[tuple[Floats, float]]:
        """Bands to begin with, and their sides; the one that was driven first."""
        sides = _SIDES[: self.parameters.classes - 1]
        warm = None if old is None else _shifted(problem, old, old.rows)
        drawn = _drawn(problem, self.parameters.interval)
        seeds = [(drawn if warm is None else warm, 0.0)]
        bent = {side: _bent(problem, drawn, side) for side in sides}
        if warm is not None and old is not None and any(b is not None for b in bent.values()):
            seeds[0] = (warm, old.side)
        for side in sides:
            gone_on = None
            if old is not None and side == -old.side and len(old.other):
                gone_on = _shifted(problem, old, old.other)
            begun = gone_on if gone_on is not None else bent[side]
            if bent[side] is not None and begun is not None and side != seeds[0][1]:
                seeds.append((begun, side))
        return seeds

    def _optimised(self, problem: LocalProblem, now: Floats, rows: Floats) -> tuple[Floats, float]:
        p, robot = self.parameters, problem.robot
        low, high, _, _ = problem.input_bounds()
        _, _, turn, rise, brake, turn_rise = robot.limits
        goal, end = problem.reference.poses[-1], float(problem.reference.speeds[-1])
        ends_here = end < 0.5 * float(problem.reference.speeds.max())
        twist = robot.motion.twist(now)
        best: tuple[Floats, float] = optimise(
            rows,
            np.array([p.outer, p.inner], dtype=float),
            np.array([p.interval, p.tolerance]),
            np.array(
                [
                    p.time,
                    p.kinematics,
                    p.speed,
                    p.acceleration,
                    p.obstacles,
                    p.near,
                    p.path,
                    p.goal,
                    p.growth,
                ]
            ),
            np.array([low[0], max(high[0], 0.05), turn, rise, brake, turn_rise, p.margin]),
            np.array([*twist, end if ends_here else np.nan, *goal]),
            np.ascontiguousarray(problem.reference.poses[:, :2]),
            robot.motion.inputs > 2,
            robot.capsule,
            robot.discs,
            np.array([p.wall_gap, p.people_gap, p.inflation]),
            _bodies(problem),
            np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
            problem.predictions.step,
            problem.walls.distance,
            problem.walls.resolution,
            problem.walls.X_MG,
        )
        return best

    def _driven(self, problem: LocalProblem, now: Floats, rows: Floats) -> Motion:
        """The band's velocities at the plan's steps, made to obey the limits."""
        twists = _twists(rows, problem.robot.motion.inputs > 2)
        starts = np.cumsum(rows[:-1, 3]) - rows[:-1, 3]
        steps = min(max(math.ceil(float(rows[:-1, 3].sum()) / self.step), 2), self.steps)
        middle = (np.arange(steps) + 0.5) * self.step
        which = np.searchsorted(starts, middle, side="right") - 1
        return followed(problem, problem.robot.motion.input(twists[which]), now)

    def _free(self, problem: LocalProblem, motion: Motion) -> Motion | None:
        """The motion as far as it touches nothing; None where that is not far enough."""
        p = self.parameters
        contact = first_contact(
            problem.robot,
            motion.poses,
            motion.step,
            people=problem.people,
            predictions=problem.predictions,
            walls=problem.walls,
            margin=p.wall_margin,
            people_margin=p.people_margin,
        )
        speed = float(np.hypot(*problem.twist[:2]))
        if contact < max(p.checked, speed / problem.robot.max_deceleration):
            return None
        if contact == math.inf:
            return motion
        kept = max(int(contact / motion.step), 1)
        return replace(motion, poses=motion.poses[: kept + 1], inputs=motion.inputs[:kept])


def _drawn(problem: LocalProblem, interval: float) -> Floats:
    """A band along the reference, in its time."""
    poses, step = problem.reference.poses, problem.reference.step
    every = max(round(interval / step), 1)
    picks = np.unique([*range(0, len(poses), every), len(poses) - 1])
    if len(picks) < _FEWEST:
        picks = np.unique(np.linspace(0, len(poses) - 1, _FEWEST).round().astype(int))
    rows = np.column_stack([poses[picks], np.append(np.diff(picks) * step, interval)])
    rows[0, :3] = problem.pose
    return rows


def _shifted(problem: LocalProblem, old: Band, rows: Floats) -> Floats | None:
    """One of the last bands from the robot on; None where it is of no use any more."""
    if not 0.0 <= problem.time - old.time <= _STALE:
        return None
    rows, goal = rows.copy(), problem.reference.poses[-1]
    if len(rows) < _FEWEST or np.hypot(*(rows[-1, :2] - goal[:2])) > 1.0:
        return None
    near = np.hypot(*(rows[: min(4, len(rows) - _FEWEST + 1), :2] - problem.pose[:2]).T)
    rows = rows[int(np.argmin(near)) :]
    if len(rows) < _FEWEST:
        return None
    turn = 2.0 * math.pi * round(float(problem.pose[2] - rows[0, 2]) / (2.0 * math.pi))
    rows[:, 2] += turn
    rows[0, :3] = problem.pose
    return rows


def _bent(problem: LocalProblem, rows: Floats, side: float) -> Floats | None:
    """The band led round whoever it first comes close to, on one side; None: nobody is near."""
    mean, radius = problem.predictions.mean[:, 0], problem.people.radius
    if not len(radius):
        return None
    times = np.append(0.0, np.cumsum(rows[:-1, 3]))
    at = np.clip((times / problem.predictions.step).astype(int), 0, mean.shape[1] - 1)
    apart = mean[:, at] - rows[None, :, :2]
    gap = np.hypot(apart[..., 0], apart[..., 1]) - radius[:, None]
    reach = problem.robot.capsule[4] + _REACH
    close = np.argwhere(gap < reach)
    if not len(close):
        return None
    person, k = close[int(np.argmin(close[:, 1]))]
    normal = side * np.array([-math.sin(rows[k, 2]), math.cos(rows[k, 2])])
    needed = max(reach + radius[person] + float(apart[person, k] @ normal), 0.0)
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(rows[:, :2], axis=0).T)))
    bump = np.exp(-0.5 * ((along - along[k]) / 0.8) ** 2)
    bump *= np.minimum(along / max(along[k], 0.1), 1.0)
    out = rows.copy()
    out[:, :2] += (needed * bump)[:, None] * normal
    legs = np.diff(out[:, :2], axis=0)
    lengths, before = np.hypot(*legs.T), np.diff(along)
    out[:-1, 3] *= np.clip(lengths / np.maximum(before, 1e-3), 1.0, 3.0)
    tangent = np.unwrap(np.append(rows[0, 2], np.arctan2(legs[:, 1], legs[:, 0])))
    out[1:-1, 2] = 0.5 * (tangent[1:-1] + tangent[2:])
    return out


def _bodies(problem: LocalProblem) -> Floats:
    n, h, states = problem.predictions.mean.shape[:3]
    return np.ascontiguousarray(problem.predictions.mean).reshape(n * h, states, 2)


def _twists(rows: Floats, holonomic: bool) -> Floats:
    """(v_x, v_y, ω) (n − 1, 3) of a band's intervals, in the frame of their middles."""
    change = np.diff(rows[:, :3], axis=0) / rows[:-1, 3:]
    middle = rows[:-1, 2] + 0.5 * np.diff(rows[:, 2])
    cos, sin = np.cos(middle), np.sin(middle)
    ahead = cos * change[:, 0] + sin * change[:, 1]
    aside = cos * change[:, 1] - sin * change[:, 0] if holonomic else np.zeros_like(ahead)
    return np.column_stack([ahead, aside, change[:, 2]])


def _as_plan(problem: LocalProblem, motion: Motion, band: Band | None, cost: float) -> LocalPlan:
    if band is None:
        return plan_of(problem, motion, Status.STOP, costs={})
    return plan_of(
        problem,
        motion,
        Status.OK,
        costs={"band": cost},
        candidate=_NAMES[band.side],
        memory=band,
    )
