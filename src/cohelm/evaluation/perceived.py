"""Crowds that somebody filmed, walked through the simulated LiDAR and told by perception.

The chair stands at the median of all sightings, or drives to and fro through it along the
direction in which the sightings spread most. It has no body: the people in a film do not see it.
The floor is open and level, and the map knows of nothing. Asked for are people within 8 m of the
chair of whom at least 30 % is visible; who comes nearer to it than 0.5 m walks through the chair
and is not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.evaluation.perceived_scores import LEAST_VISIBLE, TruePeople
from cohelm.geometry import wrap_angle
from cohelm.messages import Observation
from cohelm.recordings import Trajectories
from cohelm.simulation.chance import generator
from cohelm.simulation.sensors.localisation import Localisation, Odometry, with_error

RATE = 10.0
"""Of the LiDAR, Hz."""
SPEED = 0.8
"""Of the driving chair, m/s."""
TURN = 1.0
"""Of the chair at the ends of its line, rad/s."""
ENDS = (15.0, 85.0)
"""Percentiles of the sightings along the line between which the chair drives."""
ASKED = (0.5, 8.0)
"""Distances between which people have to be told, m."""


@value
class Instant:
    """One moment of a film as a chair is in it; n people. The observation has no readings yet."""

    observation: Observation
    pose: Annotated[Floats, Shape("3")]
    """True X_MR."""
    id: Annotated[Integers, Shape("n")]
    position: Annotated[Floats, Shape("n 2")]
    """m."""
    velocity: Annotated[Floats, Shape("n 2")]
    """m/s."""

    def truth(self, visible: Floats) -> TruePeople:
        """Who is there, and who has to be told, from the share of each (n,) that can be seen."""
        away = np.hypot(*(self.position - self.pose[:2]).T)
        return TruePeople(
            time=self.observation.time,
            id=self.id,
            position=self.position,
            velocity=self.velocity,
            visible=visible,
            centre=self.pose[:2],
            reach=ASKED[1],
            asked=(away >= ASKED[0]) & (away <= ASKED[1]) & (visible >= LEAST_VISIBLE),
        )


@value
class ChairLine:
    """Where the chair is at any time: standing, or to and fro on a line with turns at its ends."""

    centre: Annotated[Floats, Shape("2")]
    """m."""
    axis: float
    """Direction of the line, rad."""
    ends: tuple[float, float]
    """Of the line, along it from the centre, m; equal: the chair stands."""

    def at(self, time: float) -> tuple[Floats, Floats]:
        """(X_MR, twist) at ``time``; it starts at the first end and heads for the second."""
        first, second = self.ends
        length = second - first
        if length <= 0.0:
            return np.array([*self.centre, self.axis]), np.zeros(3)
        drive, turn = length / SPEED, math.pi / TURN
        leg, into = divmod(time, drive + turn)
        back = leg % 2 == 1
        done = min(into, drive) * SPEED
        along = second - done if back else first + done
        turned = max(into - drive, 0.0) * TURN
        heading = self.axis + math.pi * back + turned
        ahead = np.array([math.cos(self.axis), math.sin(self.axis)])
        pose = np.array([*(self.centre + along * ahead), wrap_angle(heading)])
        moving = into < drive
        return pose, np.array([SPEED * moving, 0.0, TURN * (not moving)])


def chair_line(trajectories: Trajectories, *, drive: bool) -> ChairLine:
    """Where the chair stands or drives in a film, from where people are in it on the whole."""
    centre = np.median(trajectories.position, axis=0)
    offset = trajectories.position - centre
    _, directions = np.linalg.eigh(np.cov(offset.T))
    axis = directions[:, -1] * np.sign(directions[np.abs(directions[:, -1]).argmax(), -1])
    ends = np.percentile(offset @ axis, ENDS) if drive else np.zeros(2)
    return ChairLine(
        centre=centre,
        axis=math.atan2(axis[1], axis[0]),
        ends=(float(ends[0]), float(ends[1])),
    )


def crowd_instants(
    trajectories: Trajectories,
    *,
    seed: int,
    drive: bool,
    start: float = 0.0,
    seconds: float = math.inf,
) -> Iterator[Instant]:
    """The moments of a film at the LiDAR's rate, with the usual errors of pose and twist.

    Args:
        trajectories: who walked where.
        seed: of the localiser's and the odometry's errors.
        drive: whether the chair drives.
        start: first moment, s since the film's first frame.
        seconds: how much of it; the film ends with its last sighting.
    """
    stop = min(start + seconds, float(trajectories.time.max(initial=0.0)))
    line = chair_line(trajectories, drive=drive)
    for pose, observation in drive_line(line, seed=seed, start=start, seconds=stop - start):
        who, position, velocity = trajectories.at(observation.time)
        yield Instant(
            observation=observation,
            pose=pose,
            id=who,
            position=position,
            velocity=velocity,
        )


def drive_line(
    line: ChairLine, *, seed: int, start: float = 0.0, seconds: float
) -> Iterator[tuple[Floats, Observation]]:
    """Where a chair truly is on its line, X_MR (3,), and what it observes but for readings.

    Args:
        line: on which it stands or drives.
        seed: of the localiser's and the odometry's errors.
        start: first moment, s.
        seconds: how long.
    """
    localisation, odometry = Localisation(), Odometry()
    wander, wheels = generator(seed, "localisation"), generator(seed, "odometry")
    error = localisation.first(wander)
    for k in range(math.floor(seconds * RATE + 1e-9)):
        time = start + k / RATE
        pose, twist = line.at(time)
        if k > 0:
            error = localisation.after(error, 1.0 / RATE, wander)
        yield (
            pose,
            Observation(
                time=time,
                pose=with_error(pose, error, line.axis),
                pose_time=time,
                twist=odometry.measure(twist, wheels),
                twist_time=time,
            ),
        )
