"""CrowdNav's test (Chen et al. 2019) with a robot that nobody sees, by its rules to the letter.

The robot drives from (0, −4) to (0, 4) past people who avoid each other only, so that their motion
is the same whatever it does. Every quarter of a second it is told where they are and how they walk,
and chooses a velocity; there is no limit on accelerations. In each step, in this order: the time is
up from 24 s on; it has hit somebody if the way swept within the step, which supposes that they keep
the velocity of before, comes nearer than both radii; it has arrived if the step ends within its
radius of the goal.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.errors import ConfigError, RecordingError
from cohelm.recordings.crowdnav import read_cases
from cohelm.recordings.outside import outside_data

DT = 0.25
"""s."""
RADIUS = 0.3
"""Of the robot and of everybody, m; the goal counts from this distance on, too."""
SPEED, TURN_RATE = 1.0, 1.0
"""m/s and rad/s (the latter of the unicycle)."""
TIME_UP = 24.0
"""s."""
DISCOMFORT = 0.2
"""A gap below this is danger, m."""
START, GOAL = np.array([0.0, -4.0, np.pi / 2.0]), np.array([0.0, 4.0])
REPLAY = Path("crowdnav") / "crowdnav_replay_circle_crossing_5.npz"
"""The recorded people of the 500 test cases, in COHELM_DATA."""

Model = Literal["holonomic", "unicycle"]
MODELS: tuple[Model, ...] = ("holonomic", "unicycle")


@value
class Seen:
    """What the robot is told at the beginning of a step."""

    time: float
    """s."""
    pose: Annotated[Floats, Shape("3")]
    velocity: Annotated[Floats, Shape("2")]
    """Its own over the floor, as chosen last, m/s."""
    turning: float
    """rad/s."""
    people: Annotated[Floats, Shape("n 4")]
    """(x, y, v_x, v_y); n may be 0."""


class Driver(Protocol):
    """Who drives a case; made anew for each."""

    def __call__(self, seen: Seen) -> Floats:
        """The velocity over the floor (2,) of a holonomic robot, (v, ω) of a unicycle."""
        ...


@dataclass(frozen=True)
class Outcome:
    """How a case ended."""

    end: Literal["success", "collision", "timeout"]
    time: float
    """Since the start, s."""
    path: float
    """Length driven, m."""
    steps: int
    danger: int
    """Steps with a gap below ``DISCOMFORT``."""
    least_gap: float
    """m."""
    poses: Floats
    """(steps + 1, 3)."""


def recorded(file: Path | None = None) -> Floats:
    """The recorded people, (cases, 101, 5, 4) of (x, y, v_x, v_y) every quarter of a second.

    Args:
        file: None: the one in COHELM_DATA.

    Raises:
        ConfigError: if it is not there or is no such recording.
    """
    if file is None:
        folder = outside_data()
        if folder is None:
            raise ConfigError(
                "needs the recorded people; COHELM_DATA is not set (or give --layout for cases of "
                "our own)",
                key="--replay",
            )
        file = folder / REPLAY
    try:
        return read_cases(file)
    except RecordingError as cause:
        raise ConfigError(cause.problem, file=file, key="--replay") from None


def run(people: Floats, driver: Driver, model: Model) -> Outcome:
    """Drive one case.

    Args:
        people: (T, n, 4) of (x, y, v_x, v_y); the last states hold beyond T.
        driver: told everything at the beginning of each step.
        model: of the robot's motion.
    """
    pose, velocity, turning = START.copy(), np.zeros(2), 0.0
    poses, gaps, path, k = [pose], [], 0.0, 0
    while True:
        now = people[min(k, len(people) - 1)]
        seen = Seen(time=k * DT, pose=pose, velocity=velocity, turning=turning, people=now)
        command = np.asarray(driver(seen), dtype=float)
        velocity, heading = moved(pose[2], command, model)
        turning = float(command[1]) if model == "unicycle" else 0.0
        gap = swept_gap(now, pose[:2], velocity)
        after = np.array([*(pose[:2] + DT * velocity), heading])
        path += DT * float(np.hypot(*velocity))
        gaps.append(gap)
        poses.append(after)
        end: Literal["success", "collision", "timeout"] | None = None
        if k * DT >= TIME_UP:
            end = "timeout"
        elif gap < 0.0:
            end = "collision"
        elif np.hypot(*(after[:2] - GOAL)) < RADIUS:
            end = "success"
        pose, k = after, k + 1
        if end is not None:
            return Outcome(
                end=end,
                time=k * DT,
                path=path,
                steps=k,
                danger=int(np.sum(np.array(gaps) < DISCOMFORT)),
                least_gap=min(gaps),
                poses=np.array(poses),
            )


def moved(heading: float, command: Floats, model: Model) -> tuple[Floats, float]:
    """(velocity over the floor (2,), heading after the step) of a command, within the limits.

    A unicycle turns first and then moves straight.
    """
    if model == "holonomic":
        speed = float(np.hypot(*command))
        return command * min(1.0, SPEED / max(speed, 1e-12)), heading
    heading += DT * float(np.clip(command[1], -TURN_RATE, TURN_RATE))
    speed = float(np.clip(command[0], 0.0, SPEED))
    return speed * np.array([np.cos(heading), np.sin(heading)]), heading


def swept_gap(people: Floats, position: Floats, velocity: Floats) -> float:
    """The least gap to anybody (n, 4) within a step if they keep their velocity, m; +inf: nobody.

    Args:
        people: (n, 4).
        position: of the robot, (2,).
        velocity: of the robot, (2,).
    """
    offset = people[:, :2] - position
    drift = DT * (people[:, 2:] - velocity)
    square = np.sum(drift**2, axis=1)
    share = -np.sum(offset * drift, axis=1) / np.where(square > 0.0, square, 1.0)
    nearest = offset + np.clip(share, 0.0, 1.0)[:, None] * drift
    return float((np.hypot(*nearest.T) - 2.0 * RADIUS).min(initial=np.inf))
