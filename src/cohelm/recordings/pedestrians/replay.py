"""Replay of a filmed or recorded crowd as pedestrians, who do not react to others.

They enter and leave at the recorded times, see ``Crowd.present``; between sightings they follow the
curve of :meth:`Trajectories.at`. People of another model may walk among them and avoid them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.errors import RecordingError
from cohelm.geometry import transform
from cohelm.recordings.outside_data import outside_data
from cohelm.recordings.pedestrians.crowdnav import STEP, read_cases
from cohelm.recordings.pedestrians.scales import Unit
from cohelm.recordings.pedestrians.socnavbench import read_episode
from cohelm.recordings.pedestrians.trajectories import (
    Trajectories,
    read_trajectories,
    trajectories_of,
)
from cohelm.simulation.api import Crowd, CrowdScene
from cohelm.simulation.crowds.behaviours import (
    DEFAULT_MODEL,
    BaseModelSpec,
    base_model,
    own_memory,
    prepare_crowd,
    with_own,
    without_own,
)
from cohelm.simulation.crowds.motion import far_away, turned_towards


class Replay:
    """People of a file. The memory is the number of the person in the film; NaN: not filmed."""

    class Parameters(Model):
        """Film, its time window, and its position on the map."""

        file: str = ""
        """Trajectories: obsmat, social-lstm, HERMES or JuPedSim text, CrowdNav's npz, or the ini of
        SocNavBench's episodes. Searched as given, beside the scenario, and in the folder
        COHELM_DATA; empty: no people."""
        unit: Unit | None = None
        """Unit of the positions in a text; None: as its header or format says."""
        step: float | None = Field(None, gt=0.0, le=10.0)
        """Time between two frames of a text, s; None: as its header or format says."""
        case: int = Field(0, ge=0)
        """Number of the case in an npz file."""
        episode: str = ""
        """Section of an ini file of SocNavBench's episodes."""
        begin: float = Field(0.0, ge=0.0, le=1e6)
        """Time of the film at which the ride begins, s since its first frame."""
        seconds: float = Field(180.0, gt=0.0, le=3600.0)
        """Duration, s; people who enter later are left out."""
        at: tuple[float, float] = (0.0, 0.0)
        """Position of the film's origin on the map, m."""
        angle_deg: float = Field(0.0, ge=-360.0, le=360.0)
        """Direction of the film's x axis on the map, degrees."""
        radius: float = Field(0.25, gt=0.05, le=1.0)
        """Radius of the bodies, m (assumed)."""
        clear: float = Field(0.0, ge=0.0, le=100.0)
        """Minimum gap to the disc about the chair at which a person appears, m; who would appear
        nearer appears later. 0: all appear as recorded."""
        walk_on: float = Field(0.0, ge=0.0, le=60.0)
        """Time for which people walk straight on before they are first and after they are last
        seen, also through walls, s; 0: they appear and vanish as recorded."""
        turn_time: float = Field(0.3, gt=0.0, le=5.0)
        """Time constant of turning the body to the direction of motion, s (assumed)."""
        walk: BaseModelSpec = DEFAULT_MODEL
        """Pedestrian model of the scenario's other people, who avoid those of the film."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._walk = base_model(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """Append the people of the film, who see no other, to those at time 0.

        Raises:
            RecordingError: if the file is missing or no film.
        """
        p = self.parameters
        others = prepare_crowd(self._walk, crowd)
        film = self._film()
        n = len(film.id)
        states, there = self._states(film, np.arange(n), 0.0)
        memory = None
        if others.memory is not None:
            memory = np.vstack([others.memory, np.full((n, others.memory.shape[1]), np.nan)])
        first = len(others.radius)
        groups = np.full(first, -1) if others.group is None else others.group
        joined = Crowd(
            position=np.vstack([others.position, states[:, :2]]),
            velocity=np.vstack([others.velocity, states[:, 2:]]),
            heading=np.append(others.heading, np.arctan2(*self._first_ways(film).T[::-1])),
            radius=np.append(others.radius, np.full(n, p.radius)),
            preferred_speed=np.append(others.preferred_speed, _mean_speeds(film)),
            waypoints=np.vstack(
                [others.waypoints, np.full((n, *others.waypoints.shape[1:]), np.nan)]
            ),
            target=np.append(others.target, np.zeros(n, dtype=np.int64)),
            loop=np.append(others.loop, np.zeros(n, dtype=np.bool_)),
            sees_robot=np.append(others.sees_robot, np.zeros(n, dtype=np.bool_)),
            group=np.append(groups, _groups(film, groups.max(initial=-1) + 1)),
            present=np.append(others.there, there),
            memory=memory,
        )
        return with_own(joined, np.append(np.full(first, np.nan), np.arange(n)))

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        number = own_memory(crowd)
        filmed = np.isfinite(number)
        inner = without_own(crowd)
        after = inner if filmed.all() else self._walk.step(inner, scene, dt, rng)
        if filmed.any():
            after = self._replayed(crowd, after, number, scene, dt)
        return with_own(after, number)

    def _replayed(
        self, before: Crowd, after: Crowd, number: Floats, scene: CrowdScene, dt: float
    ) -> Crowd:
        """``after`` with the filmed people at their recorded positions ``dt`` after the scene."""
        filmed = np.isfinite(number)
        who = number[filmed].astype(np.int64)
        states, there = self._states(self._film(), who, scene.time + dt)
        if self.parameters.clear > 0.0:
            late = there & ~before.there[filmed] & self._near(states[:, :2], scene)
            states[late, :2], states[late, 2:] = far_away(len(who))[late], 0.0
            there &= ~late
        all_states = np.column_stack([after.position, after.velocity])
        all_states[filmed] = states
        present = after.there.copy()
        present[filmed] = there
        velocity = all_states[:, 2:]
        turned = turned_towards(before.heading, velocity, dt, self.parameters.turn_time)
        return replace(
            after,
            position=all_states[:, :2],
            velocity=velocity,
            heading=np.where(filmed, turned, after.heading),
            target=np.where(filmed, before.target, after.target),
            present=present,
        )

    def _states(self, film: Trajectories, who: Integers, time: float) -> tuple[Floats, Booleans]:
        """(x, y, v_x, v_y) on the map of people ``who`` (n,), and mask of those present."""
        p = self.parameters
        n = len(who)
        states = np.hstack([far_away(n), np.zeros((n, 2))])
        ids, position, velocity = film.at(p.begin + time)
        known = np.isin(ids, film.id[who])
        at = np.searchsorted(film.id[who], ids[known])
        X_MF = np.array([*p.at, math.radians(p.angle_deg)])
        states[at, :2] = transform(X_MF, position[known])
        states[at, 2:] = transform(np.array([0.0, 0.0, X_MF[2]]), velocity[known])
        there = np.zeros(n, dtype=np.bool_)
        there[at] = True
        return states, there

    def _near(self, position: Floats, scene: CrowdScene) -> Booleans:
        """Mask of people (n, 2) too close to the chair to appear there."""
        p = self.parameters
        away = np.hypot(*(position - scene.robot_position).T)
        near: Booleans = away - scene.robot_radius - p.radius < p.clear
        return near

    def _first_ways(self, film: Trajectories) -> Floats:
        """First recorded velocity (n, 2) of each person, on the map, m/s."""
        turn = np.array([0.0, 0.0, math.radians(self.parameters.angle_deg)])
        return np.asarray(transform(turn, film.velocity[film.first[:-1]]))

    def _film(self) -> Trajectories:
        p = self.parameters
        if not p.file:
            return _NO_PEOPLE
        film = _whole(_found(p.file), p.episode or p.case, p.unit, p.step, p.walk_on)
        return _window(film, p.begin, p.begin + p.seconds)


def _found(name: str) -> Path:
    """Find the given file, or the one of that name in COHELM_DATA."""
    file, folder = Path(name), outside_data()
    if file.is_file() or folder is None:
        return file
    return folder / file


@lru_cache(maxsize=16)
def _window(film: Trajectories, begin: float, end: float) -> Trajectories:
    """Select the people of a film who are seen between two times, s."""
    return film.only((film.end >= begin) & (film.begin <= end))


@lru_cache(maxsize=4)
def _whole(
    file: Path, case: int | str, unit: Unit | None, step: float | None, walk_on: float
) -> Trajectories:
    return _read(file, case, unit, step).walking_on(walk_on)


def _read(file: Path, case: int | str, unit: Unit | None, step: float | None) -> Trajectories:
    if isinstance(case, str):
        return read_episode(file, case)[0]
    if file.suffix != ".npz":
        return read_trajectories(file, unit=unit, step=step)
    cases = read_cases(file)
    if case >= len(cases):
        raise RecordingError(f"has {len(cases)} cases and no case {case}", file=file)
    instants, n = cases.shape[1:3]
    return trajectories_of(
        name=file.name,
        step=STEP,
        who=np.repeat(np.arange(n), instants),
        time=np.tile(STEP * np.arange(instants), n),
        position=cases[case, :, :, :2].transpose(1, 0, 2).reshape(-1, 2),
    )


def _mean_speeds(film: Trajectories) -> Floats:
    """Mean speed (n,) of each person, m/s; at least 0.1."""
    speed = np.hypot(film.velocity[:, 0], film.velocity[:, 1])
    total = np.array([speed[a:b].mean() for a, b in zip(film.first, film.first[1:], strict=False)])
    return np.asarray(np.maximum(total, 0.1))


def _groups(film: Trajectories, first: int) -> Integers:
    """Numbers (n,) of the annotated groups, from ``first`` on; −1: none."""
    out = np.full(len(film.id), -1, dtype=np.int64)
    for k, members in enumerate(film.groups):
        out[np.isin(film.id, members)] = first + k
    return out


_NO_PEOPLE = Trajectories(
    name="",
    step=0.4,
    id=np.empty(0, dtype=np.int64),
    first=np.zeros(1, dtype=np.int64),
    time=np.empty(0),
    position=np.empty((0, 2)),
    velocity=np.empty((0, 2)),
)
