"""Behaviours that change how people of another model meet the chair.

The first column of such a model's memory is its own, the rest is that of the base model.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from cohelm import plugins
from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import Model
from cohelm.simulation.api import Crowd, CrowdScene, PedestrianModel
from cohelm.simulation.crowds.motion import GOLDEN_RATIO, current_targets, opposite_targets

BaseModelSpec = plugins.Spec
"""Pedestrian model whose people behave differently."""
DEFAULT_MODEL: dict[str, Any] = {"use": "orca"}
PeopleIndices = Annotated[tuple[Annotated[int, Field(ge=0, le=299)], ...], Field(max_length=300)]
"""Indices of people in the order of the scenario, from 0."""


def base_model(spec: BaseModelSpec) -> PedestrianModel:
    """Build the model that ``spec`` names.

    Raises:
        PluginError, ConfigError: see :func:`cohelm.plugins.build`.
    """
    model: PedestrianModel = plugins.build("pedestrian_models", spec, key="people.model.walk")
    return model


def prepare_crowd(model: PedestrianModel, crowd: Crowd) -> Crowd:
    """Prepare the people at time 0 for a model; see :class:`PedestrianModel`."""
    enter = getattr(model, "enter", None)
    prepared: Crowd = crowd if enter is None else enter(crowd)
    return prepared


def selected(crowd: Crowd, only: PeopleIndices) -> Booleans:
    """Mask (n,) of the people in ``only``; of all people if it is empty."""
    index = np.arange(len(crowd.radius))
    return np.isin(index, only) if only else np.ones(len(index), dtype=np.bool_)


def own_memory(crowd: Crowd) -> Floats:
    """Memory (n,) of the outer model; NaN without any."""
    if crowd.memory is None or crowd.memory.shape[1] == 0:
        return np.full(len(crowd.radius), np.nan)
    return crowd.memory[:, 0]


def without_own(crowd: Crowd) -> Crowd:
    """Remove the memory of the outer model."""
    if crowd.memory is None:
        return crowd
    inner = crowd.memory[:, 1:]
    return replace(crowd, memory=inner if inner.shape[1] else None)


def with_own(crowd: Crowd, own: Floats) -> Crowd:
    """Put the memory (n,) of the outer model first."""
    inner = np.empty((len(own), 0)) if crowd.memory is None else crowd.memory
    return replace(crowd, memory=np.column_stack([own, inner]))


def gap_to_robot(crowd: Crowd, scene: CrowdScene) -> Floats:
    """Gap (n,) between each body and the disc about the robot, m; negative where they overlap."""
    offset = crowd.position - scene.robot_position
    gap: Floats = np.hypot(offset[:, 0], offset[:, 1]) - crowd.radius - scene.robot_radius
    return gap


class Aggressive:
    """People who ignore the chair, as in Xu et al."""

    class Parameters(Model):
        """Base model and people."""

        walk: BaseModelSpec = DEFAULT_MODEL
        """Pedestrian model among people and walls."""
        only: PeopleIndices = ()
        """Aggressive people; empty: all."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._base = base_model(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """Prepare the people at time 0; those selected are blind to the robot."""
        return self._blinded(prepare_crowd(self._base, crowd))

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        after = self._base.step(self._blinded(crowd), scene, dt, rng)
        return replace(after, sees_robot=crowd.sees_robot)

    def _blinded(self, crowd: Crowd) -> Crowd:
        return replace(crowd, sees_robot=crowd.sees_robot & ~selected(crowd, self.parameters.only))


class Inattentive:
    """People who notice the chair within a distance, and avoid it a reaction time later.

    A person who has noticed it does not forget it. The memory is the time of noticing, s.
    """

    class Parameters(Model):
        """Base model, people and noticing."""

        walk: BaseModelSpec = DEFAULT_MODEL
        """Pedestrian model before and after noticing."""
        only: PeopleIndices = ()
        """Inattentive people; empty: all."""
        distance: float = Field(1.5, ge=0.0, le=50.0)
        """Gap between body and the disc about the chair at which it is noticed, m (assumed: the far
        end of Hall's personal distance, 1.2 m, and a step)."""
        reaction_time: float = Field(0.5, ge=0.0, le=10.0)
        """From noticing to avoiding, s (assumed: a choice of direction takes 0.4 to 0.6 s)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._base = base_model(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """Prepare the people at time 0, who have noticed nothing."""
        return with_own(prepare_crowd(self._base, crowd), np.full(len(crowd.radius), np.nan))

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        noticed = self._noticed(crowd, scene)
        inner = replace(without_own(crowd), sees_robot=self._reacts(crowd, noticed, scene.time))
        after = self._base.step(inner, scene, dt, rng)
        return with_own(replace(after, sees_robot=crowd.sees_robot), noticed)

    def _noticed(self, crowd: Crowd, scene: CrowdScene) -> Floats:
        """Time (n,) at which each person noticed the chair, s; NaN: not yet."""
        before = own_memory(crowd)
        near = crowd.sees_robot & (gap_to_robot(crowd, scene) <= self.parameters.distance)
        return np.where(np.isnan(before) & near, scene.time, before)

    def _reacts(self, crowd: Crowd, noticed: Floats, time: float) -> Booleans:
        p = self.parameters
        aware = np.nan_to_num(noticed, nan=np.inf) + p.reaction_time <= time + 1e-9
        return crowd.sees_robot & (aware | ~selected(crowd, p.only))


class Distracted:
    """People who ignore the chair and turn back once beside it, as in Xu et al.

    They turn to the way-point they come from, and then go on again. The base model decides how fast
    they turn: with ``orca`` its agility, a walk of 1.1 m/s is reversed in 0.37 s. The memory is the
    time of the turn, s.
    """

    class Parameters(Model):
        """Base model, people and turning."""

        walk: BaseModelSpec = DEFAULT_MODEL
        """Pedestrian model."""
        only: PeopleIndices = ()
        """Distracted people; empty: all."""
        distance: float = Field(1.5, ge=0.0, le=50.0)
        """Gap between body and the disc about the chair at which they turn, m (assumed; right
        beside the chair is the hardest case)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._base = base_model(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """Prepare the people at time 0: those selected are blind to the robot, none has turned."""
        crowd = prepare_crowd(self._base, crowd)
        blind = crowd.sees_robot & ~selected(crowd, self.parameters.only)
        return with_own(replace(crowd, sees_robot=blind), np.full(len(crowd.radius), np.nan))

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        blind = selected(crowd, self.parameters.only)
        turned, target = self._turned(crowd, scene)
        inner = replace(without_own(crowd), sees_robot=crowd.sees_robot & ~blind, target=target)
        after = self._base.step(inner, scene, dt, rng)
        return with_own(replace(after, sees_robot=crowd.sees_robot), turned)

    def _turned(self, crowd: Crowd, scene: CrowdScene) -> tuple[Floats, Integers]:
        """Time (n,) at which each person turned, s, NaN: not yet; and their targets (n,)."""
        before = own_memory(crowd)
        near = gap_to_robot(crowd, scene) <= self.parameters.distance
        now = np.isnan(before) & near & selected(crowd, self.parameters.only) & (crowd.target > 0)
        return np.where(now, scene.time, before), np.where(now, crowd.target - 1, crowd.target)


class TurningBack:
    """People on round trips who turn back where they get nowhere.

    Without it two people who meet a chair from both ends of an aisle as wide as a chair and a
    person stand there for ever. The memory is the time for which a person has been held up, s:
    it grows below a fifth of the preferred progress and shrinks above.
    """

    class Parameters(Model):
        """Base model and patience."""

        walk: BaseModelSpec = DEFAULT_MODEL
        """Pedestrian model of people on their way."""
        patience: float = Field(6.0, gt=0.0, le=600.0)
        """Median time for which a person is held up before turning back, s (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._base = base_model(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """Prepare the people at time 0, whom nothing has held up."""
        return with_own(prepare_crowd(self._base, crowd), np.zeros(len(crowd.radius)))

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        held = np.nan_to_num(own_memory(crowd))
        opposite = opposite_targets(crowd.waypoints, crowd.target)
        turns = (held > self._patience(len(held))) & (opposite >= 0)
        target = np.where(turns, opposite, crowd.target)
        after = self._base.step(replace(without_own(crowd), target=target), scene, dt, rng)
        held = np.where(_is_held_up(after), held + dt, np.maximum(held - dt, 0.0))
        return with_own(after, np.where(turns, 0.0, held))

    def _patience(self, count: int) -> Floats:
        """Patience (count,), 0.5 to 1.5 times the median: of two who meet one turns first."""
        spread = np.arange(count, dtype=np.float64) * GOLDEN_RATIO % 1.0
        return self.parameters.patience * (0.5 + spread)


def _is_held_up(crowd: Crowd) -> Booleans:
    """Mask (n,) of people who walk to a way-point and make less than a fifth of their progress."""
    offset = current_targets(crowd.waypoints, crowd.target) - crowd.position
    away = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-9)
    progress = (offset * crowd.velocity).sum(axis=1) / away
    held: Booleans = progress < 0.2 * crowd.preferred_speed  # False for NaN: those who are done
    return held
