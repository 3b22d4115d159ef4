"""Drivers of a CrowdNav case: a local planner as in a ride, and references without one."""

from __future__ import annotations

import time
from functools import cached_property
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, read_only
from cohelm.config import Model as Config
from cohelm.config import validate
from cohelm.control import LocalPlanner, LocalProblem, OptimalControl
from cohelm.control.sampling import Sampling, sample
from cohelm.control.stack import Terms
from cohelm.control.warm_start import estimate_current_input, shifted_plan
from cohelm.evaluation.external.crowdnav import (
    GOAL,
    RADIUS,
    SPEED,
    TURN_RATE,
    Driver,
    Model,
    RobotView,
    avoiding,
)
from cohelm.maps import DistanceField
from cohelm.messages import (
    Groups,
    LocalPlan,
    Observation,
    Path,
    People,
    RiderProfile,
    Status,
    WishReport,
)
from cohelm.perception import Predictor, Tracker
from cohelm.planning.reference import ComfortLimits, ReferenceSettings, make_reference
from cohelm.plugins import build
from cohelm.robots import Robot
from cohelm.robots.clearance import Clearance
from cohelm.social import SocialModel

BEST_ARC = "best_arc"
"""Name of the driver that takes the best sampled arc, in place of a planner's."""
_COMFORT = ComfortLimits(deceleration=3.0)
"""Deceleration of a robot without a rider."""
_SPACING = 0.1
_UNKNOWN, _LEARNT = 0.5, 0.5
"""Initial standard deviation of the velocities, m/s, and its time constant, s: at first all
people stand and are about to walk."""


class DriverSetup(Config):
    """Parts of a driver, for both kinds of robot."""

    planner: dict[str, Any] = Field(default_factory=lambda: {"use": "ss_mpc_dcbf"})
    """``{"use": name, **parameters}``."""
    predictor: dict[str, Any] = Field(default_factory=lambda: {"use": "constant_velocity"})
    """``{"use": name, **parameters}``."""
    caution: float = Field(0.0, ge=-0.2, le=2.0)
    """Added to the radius of each person for the planner, m."""


class PlannerDriver:
    """A local planner behind tracker, predictor and social model, with its last plan as memory."""

    def __init__(self, setup: DriverSetup, model: Model) -> None:
        self.model = model
        self.caution = setup.caution
        self.planner = _planner(setup.planner)
        self.predictor: Predictor = build("predictors", setup.predictor)
        self.tracker: Tracker = build("trackers", "given")
        self.social: SocialModel = build("social_models", "personal_space")
        self.robot = disc_robot(model)
        self.times: list[float] = []
        """Thread CPU time of each command, s."""
        self._plan: LocalPlan | None = None
        self._tracks: Any = None
        self._futures: Any = None

    def __call__(self, seen: RobotView) -> Floats:
        """See :class:`~cohelm.evaluation.external.crowdnav.Driver`."""
        begin = time.thread_time()
        self._plan = self.planner.plan(self.problem(seen), self._plan)
        self.times.append(time.thread_time() - begin)
        vx, vy, turn = self._plan.command
        if self.model == "unicycle":
            return np.array([vx, turn])
        cos, sin = np.cos(seen.pose[2]), np.sin(seen.pose[2])
        return np.array([cos * vx - sin * vy, sin * vx + cos * vy])

    def problem(self, seen: RobotView) -> LocalProblem:
        """Problem of the planner."""
        observation = _observation(seen, self.caution)
        people, self._tracks = self.tracker.track(observation, (), self._tracks)
        planner = self.planner
        predictions, self._futures = self.predictor.predict(
            people, planner.steps, planner.step, self._futures
        )
        groups = Groups.alone(len(people))
        spaces = self.social.spaces(people, groups, predictions, observation.twist, _PROFILE)
        settings = ReferenceSettings(
            steps=planner.steps,
            step=planner.step,
            speed=SPEED,
            robot=self.robot,
            comfort=_COMFORT,
        )
        ahead, _ = make_reference(_way(seen.pose), seen.pose, observation.twist, settings)
        return LocalProblem(
            time=seen.time,
            robot=self.robot,
            pose=seen.pose,
            twist=observation.twist,
            reference=ahead,
            people=people,
            predictions=predictions,
            spaces=spaces,
            walls=_NO_WALLS,
            profile=_PROFILE,
            speed_limit=SPEED,
        )


def _planner(spec: dict[str, Any]) -> LocalPlanner:
    """An installed planner, or the best sampled arc."""
    if spec.get("use") != BEST_ARC:
        found: LocalPlanner = build("local_planners", spec)
        return found
    given = {key: each for key, each in spec.items() if key != "use"}
    return BestArc(validate(BestArc.Parameters, given))


def straight(model: Model) -> Driver:
    """Straight to the goal at full speed, blind."""

    def drive(seen: RobotView) -> Floats:
        offset = GOAL - seen.pose[:2]
        if model == "unicycle":
            return np.array([SPEED, 0.0])
        return np.asarray(SPEED * offset / np.hypot(*offset))

    return drive


def orca(caution: float) -> Driver:
    """ORCA of the people with a larger radius, which assumes that they avoid the robot, too.

    Raises:
        ConfigError: if the caution is outside the bounds of ``DriverSetup``.
    """
    added = 0.01 + validate(DriverSetup, {"caution": caution}).caution

    def drive(seen: RobotView) -> Floats:
        states = np.vstack([[*seen.pose[:2], *seen.velocity], seen.people])
        offset = GOAL - seen.pose[:2]
        wanted = np.zeros((len(states), 2))
        wanted[0] = SPEED * offset / max(float(np.hypot(*offset)), SPEED)
        goals = np.tile(GOAL, (len(states), 1))
        return np.asarray(avoiding(states, wanted, goals, added)[0])

    return drive


class BestArc:
    """The best sampled arc without improvement or verification: a reference, not a planner."""

    class Parameters(Config):
        """Horizon, clearance, terms and budget."""

        steps: int = Field(24, ge=3, le=100)
        """N."""
        step: float = Field(0.25, gt=0.0, le=1.0)
        """Δt, s."""
        clearance: Clearance = Clearance()
        terms: Terms = Terms()
        sampling: Sampling = Sampling(stride=1)

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.control = OptimalControl(p.terms, p.clearance)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        current_input = estimate_current_input(problem, previous)
        steps = None if previous is None else len(previous.inputs)
        prepared = self.control.prepare(problem, current_input)
        warm = shifted_plan(problem, previous, current_input, steps)
        found = sample(prepared, self.parameters.sampling, warm)
        best = int(found.cost.argmin())
        return LocalPlan(
            time=problem.time,
            step=found.step,
            command=problem.robot.motion_model.twist(found.inputs[best, 0]),
            poses=found.poses[best],
            inputs=found.inputs[best],
            status=Status.OK,
        )


_KINEMATICS = {"holonomic": "holonomic", "unicycle": "turn_first"}
"""Kinematics of CrowdNav."""


class _Disc(Robot):
    """Robot with a polygonal footprint that stands for a disc."""

    @cached_property
    def discs(self) -> Floats:
        """Single disc."""
        return read_only(np.array([[0.0, 0.0, RADIUS]]))


def disc_robot(model: Model) -> Robot:
    """CrowdNav's robot: a disc of 0.3 m, practically without acceleration limits."""
    angles = 2.0 * np.pi * np.arange(16) / 16
    outline = RADIUS * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return _Disc(
        name=f"crowdnav_{model}",
        kinematics=_KINEMATICS[model],
        footprint=tuple((float(x), float(y)) for x, y in outline),
        max_speed=SPEED,
        max_reverse_speed=SPEED if model == "holonomic" else 0.0,
        max_turn_rate=TURN_RATE,
        max_acceleration=20.0,
        max_deceleration=20.0,
        emergency_deceleration=20.0,
        max_turn_acceleration=50.0,
        max_jerk=1000.0,
        source="CrowdNav's env.config; it limits no acceleration",
    )


def _observation(seen: RobotView, caution: float) -> Observation:
    n = len(seen.people)
    cos, sin = np.cos(seen.pose[2]), np.sin(seen.pose[2])
    vx, vy = seen.velocity
    unsure = (_UNKNOWN * np.exp(-seen.time / _LEARNT)) ** 2
    twist = np.array([cos * vx + sin * vy, cos * vy - sin * vx, seen.turning])
    return Observation(
        time=seen.time,
        pose=seen.pose,
        pose_time=seen.time,
        twist=twist,
        twist_time=seen.time,
        people=People(
            time=seen.time,
            id=np.arange(n),
            mean=seen.people,
            covariance=np.tile(np.diag([0.0, 0.0, unsure, unsure]), (n, 1, 1)),
            heading=np.full(n, np.nan),
            radius=np.full(n, RADIUS + caution),
            confidence=np.ones(n),
            source="crowdnav",
        ),
    )


def _way(pose: Floats) -> Path:
    """Straight path from the robot to the goal."""
    offset = GOAL - pose[:2]
    length = float(np.hypot(*offset))
    along = np.linspace(0.0, length, max(round(length / _SPACING), 2))
    points = pose[:2] + along[:, None] * offset / max(float(np.hypot(*offset)), 1e-9)
    return Path(
        points=points,
        length=length,
        cost=length,
        method="straight",
        wishes=WishReport(closest=np.empty(0)),
        without_wishes=points,
    )


_PROFILE = RiderProfile(preferred_speed=SPEED)
_NO_WALLS = DistanceField(
    distance=np.full((4, 4), 100.0, dtype=np.float32),
    resolution=50.0,
    X_MG=np.array([-100.0, -100.0, 0.0]),
)
