"""Timed elastic band, Rösmann et al. (2012, 2017): poses and the times between them.

A band of poses from the robot to the local goal minimises time and keeps away from obstacles: one
sparse least-squares problem. The planner optimises bands on either side of a person, and drives the
cheapest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Trajectory
from cohelm.control.baselines.teb_band import (
    Band,
    BandLimits,
    BandProblem,
    BandWeights,
    band_along_reference,
    band_around_person,
    shifted_band,
    twists,
)
from cohelm.control.baselines.teb_solver import optimise
from cohelm.control.baselines.tracking import plan_of
from cohelm.control.trajectories import braking_trajectory, limited_trajectory
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.messages import LocalPlan, Status
from cohelm.robots.contact import first_contact
from cohelm.robots.contact_kernel import ContactMargins
from cohelm.robots.wall_contact import wall_grid

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
