"""Open-loop replay of a recorded ride: recorded observations and requests, present decisions.

The chair follows its recorded track; the new decisions do not move it. With the same code and
parameters every command is equal to the bit. Otherwise the commands show the differences at each
instant of the recorded ride, not the course of another ride.
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
from cohelm.messages import Decision, Request
from cohelm.navigation import Navigator, NavigatorSetup, Tick
from cohelm.recordings import RecordedRide, RideFacts, RideTick, digest_of
from cohelm.scenarios.scenario import (
    NAVIGATOR_PARAMETERS,
    NAVIGATOR_PARTS,
    PARTS,
    Scenario,
    robot_of,
)

_REQUEST_KEYS = ("mode", "profile")
CHANGEABLE = (*NAVIGATOR_PARTS, *NAVIGATOR_PARAMETERS, "robot", *_REQUEST_KEYS)
"""Keys of a scenario that a replay can set; the others determined the recording."""
_REQUIRED = ("name", "floor", "map", "start", "goal")
"""Keys that a scenario must have, although a replay does not use them."""


@value
class ReplayedTick:
    """One tick as recorded and as replayed."""

    number: int
    """Index of the tick."""
    time: float
    """s."""
    recorded: Decision
    replayed: Decision
    tick: Tick
    """Tick of the replay."""
    same_inputs: bool
    """True where perception and planning agree to the bit, too."""

    @property
    def same(self) -> bool:
        """Check that both decisions are equal to the bit, with their reasons."""
        return identical(self.recorded, self.replayed)

    def agrees(self, tolerance: float) -> bool:
        """Check that the commands differ by at most ``tolerance``, in m/s and rad/s."""
        return self.same or bool(self.difference <= tolerance)

    @property
    def difference(self) -> float:
        """Largest component of the difference of the commands, m/s or rad/s."""
        return float(np.abs(self.recorded.twist - self.replayed.twist).max())


def replay_ride(ride: RecordedRide, settings: Iterable[str] = ()) -> Iterator[ReplayedTick]:
    """Replay a recorded ride tick by tick.

    Args:
        ride: recorded ride.
        settings: ``dotted.key=value`` of the scenario; keys of :data:`CHANGEABLE` only.

    Raises:
        ConfigError, ScenarioError, PluginError: if a setting does not fit.
        RecordingError: if no tick can be read.
    """
    settings = tuple(settings)
    scenario = scenario_of(ride.facts, settings)
    navigator = Navigator(navigator_setup(scenario, ride.facts, settings))
    changed = {key: getattr(scenario, key) for key in _REQUEST_KEYS if key in _keys(settings)}
    return _ticks(ride, navigator, changed)


def scenario_of(facts: RideFacts, settings: Iterable[str] = ()) -> Scenario:
    """Recorded scenario with settings.

    Raises:
        ScenarioError: if a setting does not fit, or determined the recording.
    """
    settings = tuple(settings)
    for key in sorted(_keys(settings) - set(CHANGEABLE)):
        problem = "determined the recording, and cannot be changed in a replay"
        if key not in Scenario.model_fields:
            problem = f"unknown{nearest(key, CHANGEABLE)}"
        raise ScenarioError(problem, key=key)
    given = {key: facts.scenario.get(key) for key in (*_REQUIRED, *CHANGEABLE)}
    data = override({key: each for key, each in given.items() if each is not None}, settings)
    return validate(Scenario, data, error=ScenarioError)


def navigator_setup(
    scenario: Scenario, facts: RideFacts, settings: Iterable[str] = ()
) -> NavigatorSetup:
    """Setup of the recorded ride's navigator, with settings.

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
) -> Iterator[ReplayedTick]:
    last: Tick | None = None
    for each in ride:
        request = _request(each, changed)
        last = navigator.step(each.observation, request, last)
        yield ReplayedTick(
            number=each.number,
            time=each.observation.time,
            recorded=each.decision,
            replayed=last.decision,
            tick=last,
            same_inputs=each.digest == digest_of(last),
        )


def _request(each: RideTick, changed: Mapping[str, Any]) -> Request:
    """Recorded request with changes."""
    if each.request is None:  # the reader repeats it from tick to tick
        raise TypeError("a tick without a request")
    return replace(each.request, **changed) if changed else each.request


def _keys(settings: Iterable[str]) -> frozenset[str]:
    """Keys of the scenario that settings change."""
    return frozenset(each.partition("=")[0].partition(".")[0].strip() for each in settings)
