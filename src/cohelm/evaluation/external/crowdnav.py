"""CrowdNav's test (Chen et al. 2019) with an invisible robot, by its original rules.

The robot drives from (0, −4) to (0, 4) among people who avoid only each other, so their motion does
not depend on it. Every 0.25 s it gets their positions and velocities and chooses a velocity without
acceleration limits. Each step is checked in this order: timeout from 24 s; collision, if the path
within the step at the people's previous velocities comes closer than both radii; success, if the
step ends within the robot's radius of the goal.

Own cases with other seeds, layouts and numbers of people use our ORCA; parameters are tuned on
these only. From the recorded starts it repeats the recorded trajectories.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.errors import ConfigError, RecordingError
from cohelm.maps import FREE, OccupancyGrid
from cohelm.recordings.outside_data import outside_data
from cohelm.recordings.pedestrians.crowdnav import read_cases
from cohelm.simulation import Orca
from cohelm.simulation.api import Crowd, CrowdScene

DT = 0.25
"""Time step, s."""
RADIUS = 0.3
"""Radius of robot and people, m, and of the goal."""
SPEED, TURN_RATE = 1.0, 1.0
"""Limits, m/s and rad/s (of the unicycle)."""
TIMEOUT = 24.0
"""Time limit, s."""
DISCOMFORT = 0.2
"""Gap below which a step counts as dangerous, m."""
START, GOAL = np.array([0.0, -4.0, np.pi / 2.0]), np.array([0.0, 4.0])
REPLAY = Path("crowdnav") / "crowdnav_replay_circle_crossing_5.npz"
"""Recorded people of the 500 test cases, in COHELM_DATA."""

Model = Literal["holonomic", "unicycle"]
MODELS: tuple[Model, ...] = ("holonomic", "unicycle")
Layout = Literal["circle", "square"]
LAYOUTS: tuple[Layout, ...] = ("circle", "square")
CIRCLE = 4.0
"""Radius of the circle crossing, m."""
SQUARE = 10.0
"""Side of the square crossing, m."""
STATES = 101
"""States of a case: 25 s."""
_SEED = 71_000_000
"""First part of the seeds, different from all others."""
_TRIES = 2000


@value
class RobotView:
    """Observation of the robot at the start of a step."""

    time: float
    """s."""
    pose: Annotated[Floats, Shape("3")]
    velocity: Annotated[Floats, Shape("2")]
    """Last chosen velocity of the robot in the map frame, m/s."""
    turning: float
    """rad/s."""
    people: Annotated[Floats, Shape("n 4")]
    """(x, y, v_x, v_y); n may be 0."""


class Driver(Protocol):
    """Driver of one case."""

    def __call__(self, seen: RobotView) -> Floats:
        """Velocity (2,) in the map frame of a holonomic robot, (v, ω) of a unicycle."""
        ...


@dataclass(frozen=True)
class CaseResult:
    """Result of a case."""

    end: Literal["success", "collision", "timeout"]
    time: float
    """Duration, s."""
    path: float
    """Driven length, m."""
    steps: int
    danger: int
    """Steps with a gap below ``DISCOMFORT``."""
    least_gap: float
    """m."""
    poses: Floats
    """(steps + 1, 3)."""


def recorded(file: Path | None = None) -> Floats:
    """Read the recorded people, (cases, 101, 5, 4) of (x, y, v_x, v_y) every 0.25 s.

    Args:
        file: recording; None: the one in COHELM_DATA.

    Raises:
        ConfigError: if it does not exist or is not such a recording.
    """
    if file is None:
        folder = outside_data()
        if folder is None:
            raise ConfigError(
                "needs the recorded people; COHELM_DATA is not set (or give "
                "--layout for own cases)",
                key="--replay",
            )
        file = folder / REPLAY
    try:
        return read_cases(file)
    except RecordingError as cause:
        raise ConfigError(cause.problem, file=file, key="--replay") from None


def run(people: Floats, driver: Driver, model: Model) -> CaseResult:
    """Run one case.

    Args:
        people: (T, n, 4) of (x, y, v_x, v_y); the last states are kept beyond T.
        driver: driver of the robot.
        model: kinematics of the robot.
    """
    pose, velocity, turning = START.copy(), np.zeros(2), 0.0
    poses, gaps, path, k = [pose], [], 0.0, 0
    while True:
        now = people[min(k, len(people) - 1)]
        seen = RobotView(time=k * DT, pose=pose, velocity=velocity, turning=turning, people=now)
        command = np.asarray(driver(seen), dtype=float)
        velocity, heading = moved(pose[2], command, model)
        turning = float(command[1]) if model == "unicycle" else 0.0
        gap = swept_gap(now, pose[:2], velocity)
        after = np.array([*(pose[:2] + DT * velocity), heading])
        path += DT * float(np.hypot(*velocity))
        gaps.append(gap)
        poses.append(after)
        end: Literal["success", "collision", "timeout"] | None = None
        if k * DT >= TIMEOUT:
            end = "timeout"
        elif gap < 0.0:
            end = "collision"
        elif np.hypot(*(after[:2] - GOAL)) < RADIUS:
            end = "success"
        pose, k = after, k + 1
        if end is not None:
            return CaseResult(
                end=end,
                time=k * DT,
                path=path,
                steps=k,
                danger=int(np.sum(np.array(gaps) < DISCOMFORT)),
                least_gap=min(gaps),
                poses=np.array(poses),
            )


def moved(heading: float, command: Floats, model: Model) -> tuple[Floats, float]:
    """(velocity (2,) in the map frame, heading after the step) of a command, within the limits.

    A unicycle turns first and then moves straight.
    """
    if model == "holonomic":
        speed = float(np.hypot(*command))
        return command * min(1.0, SPEED / max(speed, 1e-12)), heading
    heading += DT * float(np.clip(command[1], -TURN_RATE, TURN_RATE))
    speed = float(np.clip(command[0], 0.0, SPEED))
    return speed * np.array([np.cos(heading), np.sin(heading)]), heading


def swept_gap(people: Floats, position: Floats, velocity: Floats) -> float:
    """Smallest gap to people at constant velocities within a step, m; +inf without people.

    Args:
        people: states (n, 4).
        position: position of the robot, (2,).
        velocity: velocity of the robot, (2,).
    """
    offset = people[:, :2] - position
    drift = DT * (people[:, 2:] - velocity)
    square = np.sum(drift**2, axis=1)
    share = -np.sum(offset * drift, axis=1) / np.where(square > 0.0, square, 1.0)
    nearest = offset + np.clip(share, 0.0, 1.0)[:, None] * drift
    return float((np.hypot(*nearest.T) - 2.0 * RADIUS).min(initial=np.inf))


def own_case(layout: Layout, people: int, seed: int) -> Floats:
    """Trajectories (101, n, 4) of n people who cross a circle or a square, starting at rest."""
    rng = np.random.default_rng([_SEED, seed])
    starts, goals = drawn_ends(layout, people, rng)
    return walked(np.hstack([starts, np.zeros((people, 2))]), goals, STATES)


def drawn_ends(layout: Layout, people: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Starts and goals (n, 2) as CrowdNav draws them, apart from each other and the robot's.

    Args:
        layout: ``circle``: to the opposite point, both moved by up to 0.5 m; ``square``: from one
            half to the other.
        people: number n.
        rng: source of the draws.
    """
    starts, goals = np.array([START[:2]]), np.array([GOAL])
    apart = 2.0 * RADIUS + DISCOMFORT
    for _ in range(_TRIES * people):
        if len(starts) == people + 1:
            break
        start, goal = _drawn(layout, rng)
        near = min(np.hypot(*(starts - start).T).min(), np.hypot(*(goals - goal).T).min())
        if near >= apart:
            starts, goals = np.vstack([starts, start]), np.vstack([goals, goal])
    return starts[1:], goals[1:]


def _drawn(layout: Layout, rng: np.random.Generator) -> tuple[Floats, Floats]:
    if layout == "circle":
        angle = rng.uniform(0.0, 2.0 * np.pi)
        start = CIRCLE * np.array([np.cos(angle), np.sin(angle)]) + rng.uniform(-0.5, 0.5, 2)
        return start, -start
    side = rng.choice([-1.0, 1.0])
    across, along = rng.uniform(0.0, 0.5 * SQUARE, 2), rng.uniform(-0.5, 0.5, 2) * SQUARE
    return np.array([side * across[0], along[0]]), np.array([-side * across[1], along[1]])


def walked(states: Floats, goals: Floats, count: int) -> Floats:
    """States (count, n, 4) of people who walk to their goals and avoid only each other.

    Args:
        states: first states (n, 4).
        goals: (n, 2).
        count: number of states, every 0.25 s.
    """
    out = np.empty((count, *states.shape))
    out[0] = states
    for k in range(1, count):
        offset = goals - out[k - 1, :, :2]
        wanted = offset / np.maximum(np.hypot(*offset.T), SPEED)[:, None] * SPEED
        velocity = avoiding(out[k - 1], wanted, goals)
        out[k] = np.hstack([out[k - 1, :, :2] + DT * velocity, velocity])
    return out


def avoiding(states: Floats, wanted: Floats, goals: Floats, extra_radius: float = 0.01) -> Floats:
    """ORCA velocities (n, 2) of agents with preferred velocities ``wanted`` (n, 2), m/s."""
    n = len(states)
    crowd = Crowd(
        position=states[:, :2],
        velocity=states[:, 2:],
        heading=np.zeros(n),
        radius=np.full(n, RADIUS),
        preferred_speed=np.full(n, SPEED),
        waypoints=goals[:, None],
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=bool),
        sees_robot=np.zeros(n, dtype=bool),
    )
    orca = Orca(Orca.Parameters(walls=False, extra_radius=extra_radius))
    return orca.velocities(crowd, _NOTHING, wanted, np.full(n, SPEED), DT)


_NOTHING = CrowdScene(
    grid=OccupancyGrid(data=np.full((2, 2), FREE, dtype=np.int8), resolution=1.0, X_MG=np.zeros(3)),
    robot_position=np.zeros(2),
    robot_velocity=np.zeros(2),
    robot_radius=RADIUS,
    time=0.0,
)
