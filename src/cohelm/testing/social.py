"""Contract of ``social.SocialModel``."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import identical
from cohelm.messages import Groups, GroupSpaces, Predictions, RiderProfile, SocialSpaces
from cohelm.shapes import KINDS
from cohelm.social.api import SocialModel
from cohelm.testing.conformance import require, require_finite, steady
from cohelm.testing.scenes import straight_on, walkers

_STATES = (
    np.empty((0, 4)),
    np.array([[3.0, 0.0, -1.2, 0.0], [2.0, 1.0, 0.0, 0.0], [4.0, -2.0, 0.3, 0.4]]),
)
"""No person; a walking one, a standing one without heading, a slow one."""


def check_social_model(model: SocialModel, *, within: float = 1.0) -> None:
    """Check a social model: a finite, positive space for every person at every step.

    Spaces of groups must contain their members at every step.

    Raises:
        ConformanceError: naming the violated rule.
    """
    for states in _STATES:
        for speed in (0.0, 1.2):
            _check(model, states, np.array([speed, 0.0, 0.0]), within)


def _check(model: SocialModel, states: np.ndarray, twist: np.ndarray, within: float) -> None:
    people = walkers(states)
    predictions = straight_on(people, 8, 0.25)
    pair = Groups(id=np.array([5]), member=np.array([0, -1, 0]))
    groups = pair if len(people) else Groups.alone(0)
    profile = RiderProfile(social_distance=0.6)
    spaces: SocialSpaces = steady(
        lambda: model.spaces(people, groups, predictions, twist, profile),
        inputs=(people, groups, predictions, twist),
        what="spaces",
        within=within,
    )
    sizes = {"front": spaces.front, "side": spaces.side, "rear": spaces.rear, "axis": spaces.axis}
    for name, array in sizes.items():
        require(
            array.shape == predictions.deviation.shape,
            f"{name} must have a value for each person, hypothesis and step",
        )
    require_finite({**sizes, "the robot's own": spaces.robot, "scale": spaces.scale})
    require(spaces.kind in KINDS.values(), f"kind must be one of {KINDS}, is {spaces.kind}")
    for name in ("front", "side", "rear"):
        require(sizes[name] > 0.0, f"{name} must be positive")
    require(spaces.robot > 0.0, "the robot's own sizes must be positive")
    require(spaces.scale > 0.0, "scale must be positive")
    require(
        spaces.floor >= profile.social_distance,
        f"floor must respect the rider's social distance, {profile.social_distance} m",
    )
    unknown = np.isnan(people.heading)
    require(
        (spaces.front[unknown] == spaces.rear[unknown])
        & (spaces.front[unknown] == spaces.side[unknown]),
        "the space of a person whose heading is unknown must be a circle",
    )
    if spaces.groups is not None:
        _check_groups(spaces.groups, groups, predictions)


def _check_groups(spaces: GroupSpaces, groups: Groups, predictions: Predictions) -> None:
    require(identical(spaces.id, groups.id), "the spaces of groups must have their ids, in order")
    require(
        spaces.support.shape[1] == predictions.mean.shape[2],
        "a group must have a space at each step",
    )
    require_finite({"direction": spaces.direction, "support": spaces.support})
    normal = np.stack([np.cos(spaces.direction), np.sin(spaces.direction)])
    members = np.flatnonzero(groups.member >= 0)
    likely = predictions.weight[members].argmax(axis=1)
    reach = predictions.mean[members, likely] @ normal
    require(
        spaces.support[groups.member[members]] > reach, "a group's space must contain its members"
    )
