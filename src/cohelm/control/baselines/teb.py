"""Timed elastic band, Rösmann et al. (2012, 2017): poses and the times between them.

A band of poses from the robot to the local goal minimises time and keeps away from obstacles: one
sparse least-squares problem. The planner optimises bands on either side of a person, and drives the
cheapest.

It is solved by Levenberg steps on a banded system, compiled. A band is an array (n, 4): poses x, y,
θ, and in the last column the time to the next one. A term touches at most three neighbouring rows,
so the normal equations have half a bandwidth of 11.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, replace
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.polyline import nearest_on_polyline
from cohelm.control.baselines.teb_band import (
    Band,
    BandLimits,
    BandProblem,
    BandWeights,
    band_along_reference,
    band_around_person,
    resized,
    shifted_band,
    twists,
)
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.trajectories import braking_trajectory, limited_trajectory
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.kernels import CACHED, callee
from cohelm.maps.distance import sample
from cohelm.messages import LocalPlan, Status
from cohelm.robots.capsule import nearest_on_spine_in_map
from cohelm.robots.contact import first_contact
from cohelm.robots.contact_kernel import ContactMargins
from cohelm.robots.wall_contact import wall_grid

_BAND = 12
"""Entries of a matrix row on and left of its diagonal."""
_EDGE = 14
"""Residuals of the terms between neighbours."""
_NEXT_X, _NEXT_Y = 4, 5
"""Variables of an interval that are its end."""
_TINY, _MIN_TIME = 1e-6, 0.02
_FAR = 4.0
"""People farther from a pose than this are ignored, m."""
_MIN_GAIN = 1e-3
"""An iteration that gains less than this share of the cost is the last."""


@njit(**CACHED)
def optimise(band: Floats, weights: BandWeights, problem: BandProblem) -> tuple[Floats, float]:
    """(the band at the nearest local optimum, its cost); the first pose of ``band`` (n, 4) stays.

    Before each outer round the band is resized; after it obstacles weigh ``growth`` times as much.
    """
    obstacles = weights.obstacles
    cost, damping = np.inf, 1.0
    for _ in range(weights.outer):
        band = resized(band, weights.interval, weights.tolerance)
        n = band.shape[0]
        trial, cost = band.copy(), np.inf
        matrix, right = np.zeros((4 * n, _BAND)), np.zeros(4 * n)
        new_matrix, new_right = np.zeros((4 * n, _BAND)), np.zeros(4 * n)
        for i in range(weights.inner + 1):
            if i > 0:
                _move(band, _solved(matrix, right, damping), trial)
            new = _assembled(trial, new_matrix, new_right, weights, obstacles, problem)
            # a step that does not lower the cost is repeated with more damping
            if new >= cost:
                damping *= 5.0
                continue
            gain = cost - new
            band, trial = trial, band
            matrix, new_matrix, right, new_right = new_matrix, matrix, new_right, right
            cost = new
            if i > 0:
                damping = max(0.3 * damping, 1e-4)
            if gain < _MIN_GAIN * cost:
                break
        obstacles *= weights.growth
    return band, cost


@callee()
def _move(band: Floats, step: Floats, out: Floats) -> None:
    """``band`` minus a step (4n,), into ``out``."""
    for k in range(band.shape[0]):
        for i in range(4):
            out[k, i] = band[k, i] - step[4 * k + i]
        out[k, 3] = max(out[k, 3], _MIN_TIME)


@njit(**CACHED)
def _assembled(
    band: Floats,
    matrix: Floats,
    right: Floats,
    weights: BandWeights,
    obstacles: float,
    problem: BandProblem,
) -> float:
    """½ of the sum of squared residuals; JᵀJ and Jᵀr in place.

    obstacles: present weight of obstacles. Every large kernel has one call site, because each one
    would be compiled again.
    """
    n, people, walls = band.shape[0], problem.people, problem.walls
    matrix.fill(0.0)
    right.fill(0.0)
    cost = _smoothness(band, matrix, right, weights, problem)
    slope, time, bodies = np.zeros(_BAND), 0.0, people.shape[0]
    for k in range(1, n):
        time += band[k - 1, 3]
        cos, sin = math.cos(band[k, 2]), math.sin(band[k, 2])
        share = min(time / problem.person_step, people.shape[1] - 1.0)
        m = min(int(share), people.shape[1] - 2)
        share -= m
        for j in range(bodies + problem.discs.shape[0]):
            # the gap to a person or from a disc to a wall, and its slope
            if j < bodies:
                x = people[j, m, 0] + share * (people[j, m + 1, 0] - people[j, m, 0])
                y = people[j, m, 1] + share * (people[j, m + 1, 1] - people[j, m, 1])
                if math.hypot(x - band[k, 0], y - band[k, 1]) > _FAR:
                    continue
                d, nx, ny, ax, ay, _ = nearest_on_spine_in_map(problem.capsule, band[k], x, y)
                slope[0], slope[1], slope[2] = -nx, -ny, -(nx * ax + ny * ay)
                gap, needed = d - problem.capsule[4] - problem.radius[j], problem.people_gap
            else:
                disc = problem.discs[j - bodies]
                ax, ay = cos * disc[0] - sin * disc[1], sin * disc[0] + cos * disc[1]
                x, y = band[k, 0] + ax, band[k, 1] + ay
                d, gx, gy = sample(walls.distance, walls.resolution, walls.X_MG, x, y)
                slope[0], slope[1], slope[2] = gx, gy, -gx * ay + gy * ax
                gap, needed = d - disc[2], problem.wall_gap
            # both terms have the slope of the gap: together one row
            hard, soft = max(needed - gap, 0.0), max(needed + problem.inflation - gap, 0.0)
            if soft > 0.0:
                weight = weights.inflated + (obstacles if hard > 0.0 else 0.0)
                cost += 0.5 * (obstacles * hard * hard + weights.inflated * soft * soft)
                root = math.sqrt(weight)
                for i in range(3):
                    slope[i] *= -root
                pull = (obstacles * hard + weights.inflated * soft) / root
                _add(matrix, right, 4 * k, slope, 3, pull)
    return cost


@callee()
def _smoothness(
    band: Floats, matrix: Floats, right: Floats, weights: BandWeights, problem: BandProblem
) -> float:
    """Terms between neighbours, with slopes by forward differences."""
    n, cost = band.shape[0], 0.0
    residual, moved = np.zeros(_EDGE), np.zeros(_EDGE)
    slopes, place = np.zeros((_EDGE, _BAND)), np.zeros((3, 4))
    for k in range(n - 1):
        size = 4 * min(3, n - k)
        for v in range(size):
            place[v // 4, v % 4] = band[k + v // 4, v % 4]
        start = nearest_on_polyline(problem.path, place[1, 0], place[1, 1])
        for v in range(-1, size):
            if v >= 0:
                place[v // 4, v % 4] += _TINY
            if v in (_NEXT_X, _NEXT_Y):  # only these change the nearest point of the path
                near = nearest_on_polyline(problem.path, place[1, 0], place[1, 1])
            else:
                near = start
            _edge(place, k, n, weights, problem, (near.x, near.y), moved)
            if v >= 0:
                place[v // 4, v % 4] = band[k + v // 4, v % 4]
            for e in range(_EDGE):
                if v < 0:
                    residual[e] = moved[e]
                else:
                    slopes[e, v] = (moved[e] - residual[e]) / _TINY
        for e in range(_EDGE):
            cost += 0.5 * residual[e] * residual[e]
            if residual[e] != 0.0:
                _add(matrix, right, 4 * k, slopes[e], size, residual[e])
    return cost


@callee()
def _add(
    matrix: Floats, right: Floats, first: int, slope: Floats, size: int, residual: float
) -> None:
    """Add one residual to JᵀJ and Jᵀr; ``slope`` holds for ``size`` variables from ``first``."""
    for a in range(size):
        if slope[a] == 0.0:
            continue
        right[first + a] += slope[a] * residual
        for b in range(a + 1):
            matrix[first + a, a - b] += slope[a] * slope[b]


@callee()
def _edge(
    rows: Floats,
    k: int,
    n: int,
    weights: BandWeights,
    problem: BandProblem,
    near: tuple[float, float],
    out: Floats,
) -> None:
    """Residuals (14,) of the interval from pose ``k`` to the next one, and to the one after.

    near: point of the path nearest to the next pose.
    """
    limits, holonomic = problem.limits, problem.holonomic
    out.fill(0.0)
    velocity, dt = _velocity(rows, 0, holonomic), rows[0, 3]
    out[0] = math.sqrt(weights.time * max(dt, 1e-3))  # the sum of squares is the time
    if not holonomic:  # Rösmann et al. 2012, eq. (8): both poses on one arc
        dx, dy = rows[1, 0] - rows[0, 0], rows[1, 1] - rows[0, 1]
        cos = math.cos(rows[0, 2]) + math.cos(rows[1, 2])
        sin = math.sin(rows[0, 2]) + math.sin(rows[1, 2])
        out[1] = math.sqrt(weights.kinematics) * (cos * dy - sin * dx)
    _limit_speeds(velocity, math.sqrt(weights.speed), limits, holonomic, out[2:4])
    root = math.sqrt(weights.acceleration)
    if k == 0:
        now = (problem.twist[0], problem.twist[1], problem.twist[2])
        _limit_accelerations(now, velocity, 0.5 * dt, root, limits, holonomic, out[4:7])
    if k == n - 2:
        _reach_goal(rows[1], velocity, dt, weights, problem, out[10:14])
        return
    after, between = _velocity(rows, 1, holonomic), 0.5 * (dt + rows[1, 3])
    _limit_accelerations(velocity, after, between, root, limits, holonomic, out[7:10])
    root = math.sqrt(weights.path)
    out[10], out[11] = root * (rows[1, 0] - near[0]), root * (rows[1, 1] - near[1])


@callee()
def _limit_speeds(
    velocity: tuple[float, float, float],
    root: float,
    limits: BandLimits,
    holonomic: bool,
    out: Floats,
) -> None:
    """Residuals (2,) of speed and turn rate beyond the limits."""
    vx, vy, w = velocity
    margin = 1.0 - limits.margin
    if holonomic:
        out[0] = root * _excess(math.sqrt(vx * vx + vy * vy + 1e-12), -1.0, margin * limits.high)
    else:
        out[0] = root * _excess(vx, limits.low, margin * limits.high)
    out[1] = root * _excess(w, -margin * limits.turn, margin * limits.turn)


@callee()
def _limit_accelerations(
    before: tuple[float, float, float],
    after: tuple[float, float, float],
    time: float,
    root: float,
    limits: BandLimits,
    holonomic: bool,
    out: Floats,
) -> None:
    """Residuals (3,) of the accelerations between two velocities: forward, turn, sideways."""
    out[0] = root * _change(before[0], after[0], time, limits)
    turn = limits.turn_acceleration
    out[1] = root * _excess((after[2] - before[2]) / time, -turn, turn)
    if holonomic:
        out[2] = root * _change(before[1], after[1], time, limits)


@callee()
def _reach_goal(
    pose: Floats,
    velocity: tuple[float, float, float],
    dt: float,
    weights: BandWeights,
    problem: BandProblem,
    out: Floats,
) -> None:
    """Residuals (4,) of the last interval: position, heading and speed at the goal."""
    root = math.sqrt(weights.goal)
    out[0] = root * (pose[0] - problem.goal[0])
    out[1] = root * (pose[1] - problem.goal[1])
    out[2] = 0.3 * root * (pose[2] - problem.goal[2])
    if not math.isnan(problem.end_speed):
        vx, vy, _ = velocity
        speed = math.sqrt(vx * vx + vy * vy + 1e-12)
        change = _change(speed, problem.end_speed, 0.5 * dt, problem.limits)
        out[3] = math.sqrt(weights.acceleration) * change


@callee()
def _velocity(rows: Floats, k: int, holonomic: bool) -> tuple[float, float, float]:
    """(v_x, v_y, ω) of the interval that begins at ``rows[k]``, in the frame of its middle."""
    dt = max(rows[k, 3], 1e-3)
    dx, dy = rows[k + 1, 0] - rows[k, 0], rows[k + 1, 1] - rows[k, 1]
    turn = rows[k + 1, 2] - rows[k, 2]
    middle = rows[k, 2] + 0.5 * turn
    cos, sin = math.cos(middle), math.sin(middle)
    sideways = (-sin * dx + cos * dy) / dt if holonomic else 0.0
    return (cos * dx + sin * dy) / dt, sideways, turn / dt


@callee()
def _excess(x: float, low: float, high: float) -> float:
    """Distance of x outside [low, high], with its sign."""
    return max(x - high, 0.0) - max(low - x, 0.0)


@callee()
def _change(before: float, after: float, time: float, limits: BandLimits) -> float:
    """Excess of the acceleration over the robot's limits, m/s²."""
    sign = 1.0 if before + after >= 0.0 else -1.0
    return _excess(sign * (after - before) / max(time, 1e-3), -limits.braking, limits.acceleration)


@njit(**CACHED)
def _solved(matrix: Floats, right: Floats, damping: float) -> Floats:
    """(JᵀJ + λ)⁻¹ Jᵀr by a banded Cholesky; the first pose stays where it is."""
    n = matrix.shape[0]
    low, x = matrix.copy(), right.copy()
    for i in range(n):
        low[i, 0] += damping
    # identity rows for the first pose
    for i in range(3):
        x[i] = 0.0
        for d in range(1, _BAND):
            low[i, d] = 0.0
        low[i, 0] = 1.0
    for i in range(3, min(n, 3 + _BAND)):
        for j in range(3):
            if i - j < _BAND:
                low[i, i - j] = 0.0
    # factorisation
    for i in range(n):
        first = max(0, i - _BAND + 1)
        for j in range(first, i + 1):
            total = low[i, i - j]
            for m in range(max(first, j - _BAND + 1), j):
                total -= low[i, i - m] * low[j, j - m]
            low[i, i - j] = math.sqrt(max(total, 1e-12)) if i == j else total / low[j, 0]
    # forward and backward substitution
    for i in range(n):
        for m in range(max(0, i - _BAND + 1), i):
            x[i] -= low[i, i - m] * x[m]
        x[i] /= low[i, 0]
    for i in range(n - 1, -1, -1):
        for m in range(i + 1, min(n, i + _BAND)):
            x[i] -= low[m, m - i] * x[m]
        x[i] /= low[i, 0]
    return x


_SIDES = (1.0, -1.0)
"""Left and right of the person in the way."""
_ORIGINS = {0.0: "drawn", 1.0: "left", -1.0: "right"}


class Teb:
    """Optimises a band, drives its beginning, and stops if that would touch an obstacle."""

    class Parameters(Model):
        """Horizon, budget, margins and weights; after ``teb_local_planner`` unless assumed."""

        steps: int = Field(30, ge=3, le=100)
        """Steps of the reference; its end is the local goal (assumed)."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s (assumed)."""
        interval: float = Field(0.2, gt=0.05, le=1.0)
        """Desired time between poses, s (``dt_ref``; 0.3 there)."""
        tolerance: float = Field(0.06, gt=0.0, le=0.5)
        """Tolerance of this time, s (``dt_hysteresis``)."""
        outer: int = Field(2, ge=1, le=10)
        """Outer rounds, each with a resized band (4 there)."""
        inner: int = Field(7, ge=1, le=40)
        """Solver steps in each round, rejected ones included (5 there)."""
        classes: int = Field(3, ge=1, le=3)
        """Number of bands: as drawn; left of the person in the way; right as well."""
        switch_below: float = Field(0.9, gt=0.0, le=1.0)
        """Share of the present side's cost below which another side is used
        (``selection_cost_hysteresis``)."""
        wall_gap: float = Field(0.1, ge=0.0, le=1.0)
        """Minimum gap to walls, m (``min_obstacle_dist``, without the robot; assumed)."""
        people_gap: float = Field(0.35, ge=0.0, le=2.0)
        """Minimum gap to people, m (assumed)."""
        inflation: float = Field(0.4, ge=0.0, le=2.0)
        """Gap beyond these that still has a cost, m (``inflation_dist``)."""
        margin: float = Field(0.05, ge=0.0, lt=0.5)
        """Share of the speed limits that is not used (``penalty_epsilon``)."""
        time: float = Field(0.4, gt=0.0)
        """Weight of the total time, 1/s (``weight_optimaltime``, there of squared intervals)."""
        kinematics: float = Field(1000.0, ge=0.0)
        """Weight of sideways motion (``weight_kinematics_nh``)."""
        speed: float = Field(2.0, ge=0.0)
        """Weight of exceeded speeds (``weight_max_vel_x``)."""
        acceleration: float = Field(1.0, ge=0.0)
        """Weight of exceeded accelerations (``weight_acc_lim_x``)."""
        obstacles: float = Field(50.0, ge=0.0)
        """Weight of gaps below the minimum (``weight_obstacle``)."""
        inflated: float = Field(0.3, ge=0.0)
        """Weight of gaps within the inflation (``weight_inflation``; 0.1 there)."""
        path: float = Field(0.3, ge=0.0)
        """Weight of the distance from the path (``weight_viapoint``, with dense points)."""
        goal: float = Field(20.0, ge=0.0)
        """Weight of the distance from the local goal; fixed there, but a person may stand on it."""
        growth: float = Field(2.0, ge=1.0, le=10.0)
        """Growth of the weight of obstacles per round (``weight_adapt_factor``)."""
        feasible_time: float = Field(0.8, gt=0.0, le=5.0)
        """Time for which the band must be free of contact, s (``feasibility_check_no_poses``)."""
        wall_margin: float = Field(0.03, ge=0.0)
        """Gap to walls that counts as contact there, m (assumed)."""
        people_margin: float = Field(0.15, ge=0.0)
        """Gap to people that counts as contact there, m (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem, self.steps)
        problem = problem.truncated(self.steps)
        current_input = estimate_current_input(problem, previous)
        memory = previous.memory if previous is not None else None
        old = memory if isinstance(memory, Band) else None
        band, cost = self._cheapest(problem, current_input, old)
        trajectory = self._until_contact(problem, self._driven(problem, current_input, band.rows))
        if trajectory is None:
            rows, cost = self._optimised(
                problem, current_input, band_along_reference(problem, self.parameters.interval)
            )
            band = self._band(problem, rows, 0.0)
            trajectory = self._until_contact(problem, self._driven(problem, current_input, rows))
        if trajectory is None:
            rest = braking_trajectory(problem, current_input, self.steps)
            return _as_plan(problem, rest, None, math.inf)
        return _as_plan(problem, trajectory, band, cost)

    def _cheapest(
        self, problem: LocalProblem, current_input: Floats, old: Band | None
    ) -> tuple[Band, float]:
        """The cheapest band of all sides; switching the side requires a clear gain."""
        found = []
        for k, (rows, side) in enumerate(self._seeds(problem, old)):
            optimised, cost = self._optimised(problem, current_input, rows)
            found.append(
                (cost * (self.parameters.switch_below if k == 0 else 1.0), cost, optimised, side)
            )
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
        """Initial bands and their sides; the one that was driven comes first."""
        sides = _SIDES[: self.parameters.classes - 1]
        warm = None if old is None else shifted_band(problem, old, old.rows)
        fresh = band_along_reference(problem, self.parameters.interval)
        seeds = [(fresh if warm is None else warm, 0.0)]
        around = {side: band_around_person(problem, fresh, side) for side in sides}
        if warm is not None and old is not None and any(b is not None for b in around.values()):
            seeds[0] = (warm, old.side)
        for side in sides:
            continued = None
            if old is not None and side == -old.side and len(old.other):
                continued = shifted_band(problem, old, old.other)
            begun = continued if continued is not None else around[side]
            if around[side] is not None and begun is not None and side != seeds[0][1]:
                seeds.append((begun, side))
        return seeds

    def _optimised(
        self, problem: LocalProblem, current_input: Floats, rows: Floats
    ) -> tuple[Floats, float]:
        p, robot, predictions = self.parameters, problem.robot, problem.predictions
        low, high, _, _ = problem.input_bounds()
        _, _, turn, rise, brake, turn_rise = robot.limits.tolist()
        end = float(problem.reference.speeds[-1])
        ends_here = end < 0.5 * float(problem.reference.speeds.max())
        n, h, states = predictions.mean.shape[:3]
        weights = BandWeights(**{name: getattr(p, name) for name in BandWeights._fields})
        top = max(float(high[0]), 0.05)
        task = BandProblem(
            limits=BandLimits(float(low[0]), top, turn, rise, brake, turn_rise, p.margin),
            twist=robot.motion_model.twist(current_input),
            end_speed=end if ends_here else math.nan,
            goal=problem.reference.poses[-1],
            path=np.ascontiguousarray(problem.reference.poses[:, :2]),
            holonomic=robot.motion_model.inputs > 2,
            capsule=robot.capsule,
            discs=robot.discs,
            wall_gap=p.wall_gap,
            people_gap=p.people_gap,
            inflation=p.inflation,
            people=np.ascontiguousarray(predictions.mean).reshape(n * h, states, 2),
            radius=np.repeat(problem.people.radius, h),
            person_step=predictions.step,
            walls=wall_grid(problem.walls),
        )
        best: tuple[Floats, float] = optimise(rows, weights, task)
        return best

    def _driven(self, problem: LocalProblem, current_input: Floats, rows: Floats) -> Trajectory:
        """The band's velocities at the plan's steps, within the limits."""
        velocities = twists(rows, problem.robot.motion_model.inputs > 2)
        starts = np.cumsum(rows[:-1, 3]) - rows[:-1, 3]
        steps = min(max(math.ceil(float(rows[:-1, 3].sum()) / self.step), 2), self.steps)
        middle = (np.arange(steps) + 0.5) * self.step
        which = np.searchsorted(starts, middle, side="right") - 1
        return limited_trajectory(
            problem, problem.robot.motion_model.input(velocities[which]), current_input
        )

    def _until_contact(self, problem: LocalProblem, trajectory: Trajectory) -> Trajectory | None:
        """The trajectory up to its first contact; None if that comes too soon."""
        p = self.parameters
        contact = first_contact(
            problem.robot,
            trajectory.poses,
            trajectory.step,
            people=problem.people,
            predictions=problem.predictions,
            walls=problem.walls,
            margins=ContactMargins(p.wall_margin, p.people_margin),
        )
        speed = float(np.hypot(*problem.twist[:2]))
        if contact < max(p.feasible_time, speed / problem.robot.max_deceleration):
            return None
        if contact == math.inf:
            return trajectory
        kept = max(int(contact / trajectory.step), 1)
        return replace(
            trajectory, poses=trajectory.poses[: kept + 1], inputs=trajectory.inputs[:kept]
        )


def _as_plan(
    problem: LocalProblem, trajectory: Trajectory, band: Band | None, cost: float
) -> LocalPlan:
    if band is None:
        return plan_of(problem, trajectory, Status.STOP, costs={})
    return plan_of(
        problem,
        trajectory,
        Status.OK,
        costs={"band": cost},
        candidate=_ORIGINS[band.side],
        memory=band,
    )
