"""Filmed crowds in front of a simulated LiDAR on a chair that is not in the film.

The chair stands at the median of all sightings, or drives back and forth through it along the
direction of their largest variance. It has no body, since the people do not react to it. The floor
is open and level, and the map is empty. People within 8 m of the chair with a visible share of at
least 30 % have to be detected; closer than 0.5 m they walk through the chair and do not count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.evaluation.perception.tracking_scores import LEAST_VISIBLE, TruePeople
from cohelm.geometry import wrap_angle
from cohelm.maps import FREE, OccupancyGrid
from cohelm.messages import Observation, PointCloud
from cohelm.recordings import Trajectories
from cohelm.robots import LidarMount
from cohelm.simulation.random_streams import generator
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.localisation import Localisation, Odometry, with_error
from cohelm.simulation.sensors.point_cloud import sweep_cloud
from cohelm.simulation.sensors.static_scene import StaticScene

RATE = 10.0
"""Rate of the LiDAR, Hz."""
SPEED = 0.8
"""Speed of the chair, m/s."""
TURN = 1.0
"""Turn rate of the chair at the ends of its line, rad/s."""
ENDS = (15.0, 85.0)
"""Percentiles of the sightings along the line at which the chair turns."""
REQUIRED = (0.5, 8.0)
"""Range of distances in which people have to be detected, m."""
HEIGHT = (1.70, 0.08)
"""Mean and standard deviation of body heights, m (assumed)."""
RADIUS = 0.25
"""Radius of each body, m."""
FACING_SPEED = 0.2
"""Speed above which a body faces its motion, m/s; below it keeps its heading."""
_MARGIN = 12.0  # floor around all sightings, m
_CELL = 0.5


@value
class FilmInstant:
    """One instant of a film around a chair; n people. The observation has no readings yet."""

    observation: Observation
    pose: Annotated[Floats, Shape("3")]
    """True X_MR."""
    id: Annotated[Integers, Shape("n")]
    position: Annotated[Floats, Shape("n 2")]
    """m."""
    velocity: Annotated[Floats, Shape("n 2")]
    """m/s."""

    def truth(self, visible: Floats) -> TruePeople:
        """True people, with those that have to be detected, from their visible shares (n,)."""
        away = np.hypot(*(self.position - self.pose[:2]).T)
        return TruePeople(
            time=self.observation.time,
            id=self.id,
            position=self.position,
            velocity=self.velocity,
            visible=visible,
            centre=self.pose[:2],
            extent=REQUIRED[1],
            required=(away >= REQUIRED[0]) & (away <= REQUIRED[1]) & (visible >= LEAST_VISIBLE),
        )


@value
class ChairLine:
    """Motion of the chair: standing, or back and forth on a line with turns at its ends."""

    centre: Annotated[Floats, Shape("2")]
    """m."""
    axis: float
    """Direction of the line, rad."""
    ends: tuple[float, float]
    """Ends of the line, along it from the centre, m; equal: the chair stands."""

    def at(self, time: float) -> tuple[Floats, Floats]:
        """(X_MR, twist) at ``time``, s; the chair starts at the first end towards the second."""
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
    """Motion of the chair in a film, from the distribution of all sightings."""
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
) -> Iterator[FilmInstant]:
    """Instants of a film at the rate of the LiDAR, with the usual errors of pose and twist.

    Args:
        trajectories: the film.
        seed: seed of the errors of localisation and odometry.
        drive: drive the chair.
        start: first instant, s since the first frame.
        seconds: duration, s; the film ends with its last sighting.
    """
    stop = min(start + seconds, float(trajectories.time.max(initial=0.0)))
    line = chair_line(trajectories, drive=drive)
    for pose, observation in drive_line(line, seed=seed, start=start, seconds=stop - start):
        who, position, velocity = trajectories.at(observation.time)
        yield FilmInstant(
            observation=observation,
            pose=pose,
            id=who,
            position=position,
            velocity=velocity,
        )


def drive_line(
    line: ChairLine, *, seed: int, start: float = 0.0, seconds: float
) -> Iterator[tuple[Floats, Observation]]:
    """True pose X_MR (3,) of a chair on its line, and its observation without readings.

    Args:
        line: motion of the chair.
        seed: seed of the errors of localisation and odometry.
        start: first instant, s.
        seconds: duration, s.
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


@value
class BodyTraits:
    """Body traits of n people in k sightings, ordered as in ``Trajectories``."""

    walked: Annotated[Floats, Shape("k")]
    """Distance since the person's first sighting, m."""
    heading: Annotated[Floats, Shape("k")]
    """rad."""
    height: Annotated[Floats, Shape("n")]
    """m."""


def body_traits(trajectories: Trajectories, seed: int) -> BodyTraits:
    """Body traits of the people of a film; heights are drawn from ``seed``."""
    n, first = len(trajectories.id), trajectories.first
    whose = np.repeat(np.arange(n), np.diff(first))
    step = np.hypot(*np.diff(trajectories.position, axis=0, prepend=np.zeros((1, 2))).T)
    total = np.cumsum(step)
    velocity = trajectories.velocity
    moving = np.hypot(velocity[:, 0], velocity[:, 1]) >= FACING_SPEED
    last = np.where(moving, np.arange(len(whose)), first[whose])
    last = np.maximum.accumulate(last)
    height = HEIGHT[0] + HEIGHT[1] * generator(seed, "bodies").standard_normal(n)
    return BodyTraits(
        walked=total - total[first[whose]],
        heading=np.arctan2(velocity[last, 1], velocity[last, 0]),
        height=np.clip(height, 1.45, 1.95),
    )


def bodies_at(trajectories: Trajectories, cast: BodyTraits, instant: FilmInstant) -> HumanBodies:
    """Bodies of the people at an instant."""
    who = np.searchsorted(trajectories.id, instant.id)
    time = instant.observation.time
    at = np.maximum(trajectories.last_before(time), trajectories.first[:-1])[who]
    speed = np.hypot(instant.velocity[:, 0], instant.velocity[:, 1])
    course = np.arctan2(instant.velocity[:, 1], instant.velocity[:, 0])
    since = np.hypot(*(instant.position - trajectories.position[at]).T)
    return HumanBodies(
        position=instant.position,
        heading=np.where(speed >= FACING_SPEED, course, cast.heading[at]),
        walked=cast.walked[at] + since,
        speed=speed,
        height=cast.height[who],
        radius=np.full(len(who), RADIUS),
    )


class CrowdLidar:
    """LiDAR among the people of a film, on an open and level floor; equal for equal seeds.

    Args:
        trajectories: the film.
        seed: seed of noise and bodies, ≥ 0.
        mount: mounted sensor; None: the default one.
    """

    def __init__(
        self, trajectories: Trajectories, seed: int, mount: LidarMount | None = None
    ) -> None:
        self.mount = mount or LidarMount()
        self._film, self._cast = trajectories, body_traits(trajectories, seed)
        self._scenery = StaticScene(grid=_open_floor(trajectories))
        self._rng = generator(seed, "lidar 0")

    def __call__(self, instant: FilmInstant) -> tuple[PointCloud, Floats]:
        """Point cloud, and the visible share of each person (n,)."""
        sweep = sweep_cloud(
            self.mount,
            self._scenery,
            bodies_at(self._film, self._cast, instant),
            instant.pose,
            time=instant.observation.time,
            rng=self._rng,
        )
        return sweep.cloud, sweep.visible


def _open_floor(trajectories: Trajectories) -> OccupancyGrid:
    low = trajectories.position.min(axis=0) - _MARGIN
    size = trajectories.position.max(axis=0) + _MARGIN - low
    columns, rows = np.ceil(size / _CELL).astype(int)
    return OccupancyGrid(
        data=np.full((rows, columns), FREE, dtype=np.int8),
        resolution=_CELL,
        X_MG=np.array([*low, 0.0]),
    )
