"""Contract of ``perception.GroupDetector``."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

import numpy as np

from cohelm.arrays import Integers
from cohelm.messages import Groups, People
from cohelm.perception.api import GroupDetector
from cohelm.testing.conformance import require, steady
from cohelm.testing.scenes import walkers

_TICK = 0.1


def check_group_detector(detector: GroupDetector, *, within: float = 1.0) -> None:
    """Check a detector of groups without people, with one person, and with four for five seconds.

    Two walk side by side, one comes towards them, one stands far away. After five seconds the two
    must be a group of their own with a constant id; a detector that never finds groups passes,
    too. The order of the people must not matter.

    Raises:
        ConformanceError: naming the violated rule.
    """
    crowd = np.array(
        [[3.0, 0.0, 1.2, 0.0], [3.0, 0.7, 1.2, 0.0], [9.0, 5.0, -1.0, 0.3], [0.0, -6.0, 0.0, 0.0]]
    )
    memory: Any = None
    turned: Any = None
    ids: list[int] = []
    for k in range(51):
        time = k * _TICK
        states = crowd[: (0, 1, 4)[min(k // 3, 2)]].copy()
        states[:, :2] += time * states[:, 2:]
        people = walkers(states, time=time)
        groups, memory = _group(detector, people, memory, within)
        order = np.arange(len(people))[::-1]
        other, turned = _group(detector, _reordered(people, order), turned, within)
        require(
            _members(people, groups) == _members(_reordered(people, order), other),
            "groups must not depend on the order of the people",
        )
        require(groups.member[2:] == -1, "must not add people who walk alone")
        ids += groups.id.tolist()
    require(len(set(ids)) <= 1, f"must keep a group's id from call to call, but gives {set(ids)}")
    require(
        not ids or len(groups.id) == 1,
        "must find two people who walk side by side within five seconds",
    )


def _group(
    detector: GroupDetector, people: People, memory: Any, within: float
) -> tuple[Groups, Any]:
    groups: Groups
    groups, after = steady(
        partial(detector.group, people, memory),
        inputs=(people, memory),
        what="group",
        within=within,
    )
    require(groups.member.shape == (len(people),), "must give each person a group or none")
    require((groups.member >= -1) & (groups.member < len(groups.id)), "member must be an index")
    require(len(np.unique(groups.id)) == len(groups.id), "two groups must not share an id")
    sizes = np.bincount(groups.member[groups.member >= 0], minlength=len(groups.id))
    require(sizes >= 2, "a group must have two members or more")
    return groups, after


def _members(people: People, groups: Groups) -> dict[int, list[int]]:
    """Ids of the people in each group, by the id of the group."""
    return {
        int(each): sorted(people.id[groups.member == k].tolist())
        for k, each in enumerate(groups.id)
    }


def _reordered(people: People, order: Integers) -> People:
    """Return the people in another order."""
    parts = ("id", "mean", "covariance", "heading", "radius", "confidence")
    return dataclasses.replace(people, **{name: getattr(people, name)[order] for name in parts})
