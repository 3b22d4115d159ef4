"""Who drives a CrowdNav case: a local planner as in a ride, and two references without one."""

from __future__ import annotations

import time
from functools import cached_property
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, read_only
from cohelm.config import Model as Config
from cohelm.config import validate
from cohelm.control import LocalPlanner, LocalProblem
from cohelm.evaluation.best_arc import BestArc
from cohelm.evaluation.crowdnav import GOAL, RADIUS, SPEED, TURN_RATE, Driver, Model, Seen
from cohelm.evaluation.crowdnav_cases import avoiding
from cohelm.maps import DistanceField
from cohelm.messages import (
    Groups,
    LocalPlan,
    Observation,
    Path,
    People,
    RiderProfile,
    WishReport,
)
from cohelm.perception import Predictor, Tracker
from cohelm.planning.reference import Comfort, reference
from cohelm.plugins import build
from cohelm.robots import Robot
from cohelm.social import SocialModel

BEST_ARC = "best_arc"
"""Names the driving of the best sampled arc where a planner is named."""
_COMFORT = Comfort(deceleration=3.0)
"""Nobody sits in this robot, and it may arrive as fast as it likes."""
_SPACING = 0.1
_UNKNOWN, _LEARNT = 0.5, 0.5
"""Deviation of the velocity of who was never seen before, m/s, and the time constant in which it is
known, s: at first everybody stands, and is about to walk."""


class Setup(Config):
    """What drives: one set for both kinds of robot."""

    planner: dict[str, Any] = Field(default_factory=lambda: {"use": "ss_mpc_dcbf"})
    """``{"use": name, **parameters}``."""
    predictor: dict[str, Any] = Field(default_factory=lambda: {"use": "constant_velocity"})
    """The same of the predictor."""
    caution: float = Field(0.0, ge=-0.2, le=2.0)
    """Added to everybody's radius as the planner is told it, m."""


class PlannerDriver:
    """A local planner behind tracker, predictor and social model, with its last plan as memory."""

    def __init__(self, setup: Setup, model: Model) -> None:
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

    def __call__(self, seen: Seen) -> Floats:
        """See :class:`~cohelm.evaluation.crowdnav.Driver`."""
        begin = time.thread_time()
        self._plan = self.planner.plan(self.problem(seen), self._plan)
        self.times.append(time.thread_time() - begin)
        vx, vy, turn = self._plan.command
        if self.model == "unicycle":
            return np.array([vx, turn])
        cos, sin = np.cos(seen.pose[2]), np.sin(seen.pose[2])
        return np.array([cos * vx - sin * vy, sin * vx + cos * vy])

    def problem(self, seen: Seen) -> LocalProblem:
        """What the planner is asked."""
        observation = _observation(seen, self.caution)
        people, self._tracks = self.tracker.track(observation, (), self._tracks)
        planner = self.planner
        predictions, self._futures = self.predictor.predict(
            people, planner.steps, planner.step, self._futures
        )
        groups = Groups.alone(len(people))
        spaces = self.social.spaces(people, groups, predictions, observation.twist, _PROFILE)
        ahead, _ = reference(
            _way(seen.pose),
            seen.pose,
            observation.twist,
            steps=planner.steps,
            step=planner.step,
            speed=SPEED,
            robot=self.robot,
            comfort=_COMFORT,
        )
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
    """An installed planner, or sampling alone."""
    if spec.get("use") != BEST_ARC:
        found: LocalPlanner = build("local_planners", spec)
        return found
    given = {key: each for key, each in spec.items() if key != "use"}
    return BestArc(validate(BestArc.Parameters, given))


def straight(model: Model) -> Driver:
    """Straight to the goal at full speed, blind."""

    def drive(seen: Seen) -> Floats:
        offset = GOAL - seen.pose[:2]
        if model == "unicycle":
            return np.array([SPEED, 0.0])
        return np.asarray(SPEED * offset / np.hypot(*offset))

    return drive


def orca(caution: float) -> Driver:
    """ORCA as the people's, that supposes that they avoid the robot too, with a wider radius.

    Raises:
        ConfigError: if that is beyond what ``Setup`` allows.
    """
    added = 0.01 + validate(Setup, {"caution": caution}).caution

    def drive(seen: Seen) -> Floats:
        states = np.vstack([[*seen.pose[:2], *seen.velocity], seen.people])
        offset = GOAL - seen.pose[:2]
        wanted = np.zeros((len(states), 2))
        wanted[0] = SPEED * offset / max(float(np.hypot(*offset)), SPEED)
        goals = np.tile(GOAL, (len(states), 1))
        return np.asarray(avoiding(states, wanted, goals, added)[0])

    return drive


_KINEMATICS = {"holonomic": "holonomic", "unicycle": "turn_first"}
"""As CrowdNav moves them."""


class _Disc(Robot):
    """A robot whose footprint is told as a polygon but is meant as a disc."""

    @cached_property
    def discs(self) -> Floats:
        """The one disc."""
        return read_only(np.array([[0.0, 0.0, RADIUS]]))


def disc_robot(model: Model) -> Robot:
    """CrowdNav's robot: a disc of 0.3 m that speeds up, brakes and turns as it likes."""
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
        source="CrowdNav's env.config; it limits no acceleration",
    )


def _observation(seen: Seen, caution: float) -> Observation:
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
    """Straight from the robot to the goal."""
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
