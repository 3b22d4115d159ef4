"""Riding a recorded ride again: the same observations and requests, and what is decided now.

The loop is open: the chair goes where it went then, whatever is decided now. With the same code and
parameters every command is the same to the bit; with others the commands say what would be
different at each instant of that ride, not how another ride would have gone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import identical, value
from cohelm.config import nearest, override, validate
from cohelm.errors import ScenarioError
from cohelm.evaluation.scenario import (
    NAVIGATOR_PARAMETERS,
    NAVIGATOR_PARTS,
    PARTS,
    Scenario,
    robot_of,
)
from cohelm.messages import Decision, Request
from cohelm.navigation import Navigator, NavigatorSetup, Tick
from cohelm.recordings import RecordedRide, RideFacts, RideTick, made_of

_OF_THE_REQUEST = ("mode", "profile")
CHANGEABLE = (*NAVIGATOR_PARTS, *NAVIGATOR_PARAMETERS, "robot", *_OF_THE_REQUEST)
"""Keys of a scenario that a replay can set; all others made what was recorded."""
_PLACE = ("name", "floor", "map", "start", "goal")
"""Keys that a scenario must have, though a replay asks for none of them."""


@value
class Compared:
    """One tick, then and now."""

    number: int
    """Of the tick, from 0 on."""
    time: float
    """s."""
    then: Decision
    now: Decision
    tick: Tick
    """All of it, as of now."""
    same_way: bool
    """Whether what led to the decision agrees, too, to the bit: what was seen and planned."""

    @property
    def same(self) -> bool:
        """Whether both decisions agree to the bit, reasons included."""
        return identical(self.then, self.now)

    def agrees(self, tolerance: float) -> bool:
        """Whether the commands differ by no more than ``tolerance``, in m/s and rad/s."""
        return self.same or bool(self.difference <= tolerance)

    @property
    def difference(self) -> float:
        """Between the commands, the greatest of their parts, m/s or rad/s."""
        return float(np.abs(self.then.twist - self.now.twist).max())


def replayed(ride: RecordedRide, settings: Iterable[str] = ()) -> Iterator[Compared]:
    """Ride a recorded ride again, tick by tick.

    Args:
        ride: as recorded.
        settings: ``dotted.key=value`` of the scenario; keys of :data:`CHANGEABLE` only.

    Raises:
        ConfigError, ScenarioError, PluginError: if a setting does not fit.
        RecordingError: if there is no tick to be read.
    """
    settings = tuple(settings)
    scenario = scenario_of(ride.facts, settings)
    navigator = Navigator(navigator_setup(scenario, ride.facts, settings))
    changed = {key: getattr(scenario, key) for key in _OF_THE_REQUEST if key in _keys(settings)}
    return _ticks(ride, navigator, changed)


def scenario_of(facts: RideFacts, settings: Iterable[str] = ()) -> Scenario:
    """The recorded scenario, with settings put in.

    Raises:
        ScenarioError: if a setting does not fit, or concerns what was recorded.
    """
    settings = tuple(settings)
    for key in sorted(_keys(settings) - set(CHANGEABLE)):
        problem = "made what was recorded, and cannot be changed afterwards"
        if key not in Scenario.model_fields:
            problem = f"unknown{nearest(key, CHANGEABLE)}"
        raise ScenarioError(problem, key=key)
    kept = {key: facts.scenario.get(key) for key in (*_PLACE, *CHANGEABLE)}
    data = override({key: each for key, each in kept.items() if each is not None}, settings)
    return validate(Scenario, data, error=ScenarioError)


def navigator_setup(
    scenario: Scenario, facts: RideFacts, settings: Iterable[str] = ()
) -> NavigatorSetup:
    """What the recorded ride's navigator was made of, with settings put in.

    Raises:
        ConfigError, PluginError: if a part is not installed, or its parameters do not fit.
    """
    robot = robot_of(scenario) if "robot" in _keys(settings) else facts.robot
    parts = {
        key: plugins.build(PARTS[key][0], getattr(scenario, key), key=key, error=ScenarioError)
        for key in NAVIGATOR_PARTS
    }
    return NavigatorSetup(
        grid=facts.grid,
        robot=robot,
        filters=facts.filters,
        heat=facts.heat,
        **parts,
        **{key: getattr(scenario, key) for key in NAVIGATOR_PARAMETERS},
    )


def _ticks(
    ride: RecordedRide, navigator: Navigator, changed: Mapping[str, Any]
) -> Iterator[Compared]:
    last: Tick | None = None
    for each in ride:
        request = _request(each, changed)
        last = navigator.step(each.observation, request, last)
        yield Compared(
            number=each.number,
            time=each.observation.time,
            then=each.decision,
            now=last.decision,
            tick=last,
            same_way=each.made == made_of(last),
        )


def _request(each: RideTick, changed: Mapping[str, Any]) -> Request:
    """As it was recorded, but for what is to be changed."""
    if each.request is None:  # the reader carries it on from tick to tick
        raise TypeError("a tick without a request")
    return replace(each.request, **changed) if changed else each.request


def _keys(settings: Iterable[str]) -> frozenset[str]:
    """The scenario's keys that settings reach into."""
    return frozenset(each.partition("=")[0].partition(".")[0].strip() for each in settings)
