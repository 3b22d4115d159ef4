"""What the models have in common that change how other models' people behave.

The first column of such a model's memory is its own, the rest is that of the model it changes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from cohelm import plugins
from cohelm.arrays import Booleans, Floats
from cohelm.simulation.api import Crowd, PedestrianModel, Scene

Walk = plugins.Spec
"""Another pedestrian model."""

WALKERS: dict[str, Any] = {"use": "orca"}
"""How people walk whose behaviour is changed, where nothing is said."""

Only = Annotated[tuple[Annotated[int, Field(ge=0, le=299)], ...], Field(max_length=300)]
"""Numbers of people in the order of the scenario, from 0."""


def walking(spec: Walk) -> PedestrianModel:
    """The model that ``spec`` names.

    Raises:
        PluginError, ConfigError: see :func:`cohelm.plugins.build`.
    """
    model: PedestrianModel = plugins.build("pedestrian_models", spec, key="people.model.walk")
    return model


def entered(model: PedestrianModel, crowd: Crowd) -> Crowd:
    """The people as a model wants them at time 0; see :class:`PedestrianModel`."""
    enter = getattr(model, "enter", None)
    changed: Crowd = crowd if enter is None else enter(crowd)
    return changed


def chosen(crowd: Crowd, only: Only) -> Booleans:
    """Which people (n,) are meant; nobody named: everybody."""
    number = np.arange(len(crowd.radius))
    return np.isin(number, only) if only else np.ones(len(number), dtype=np.bool_)


def remembered(crowd: Crowd) -> Floats:
    """A model's own record (n,); NaN where it has none."""
    if crowd.memory is None or crowd.memory.shape[1] == 0:
        return np.full(len(crowd.radius), np.nan)
    return crowd.memory[:, 0]


def without_own(crowd: Crowd) -> Crowd:
    """The crowd with the memory of the inner model."""
    if crowd.memory is None:
        return crowd
    inner = crowd.memory[:, 1:]
    return replace(crowd, memory=inner if inner.shape[1] else None)


def with_own(crowd: Crowd, own: Floats) -> Crowd:
    """The inner model's crowd with a model's own record (n,) put first in its memory."""
    inner = np.empty((len(own), 0)) if crowd.memory is None else crowd.memory
    return replace(crowd, memory=np.column_stack([own, inner]))


def gap_to_robot(crowd: Crowd, scene: Scene) -> Floats:
    """From each body (n,) to the disc about the robot, m; negative where they overlap."""
    away = crowd.position - scene.robot_position
    gap: Floats = np.hypot(away[:, 0], away[:, 1]) - crowd.radius - scene.robot_radius
    return gap
