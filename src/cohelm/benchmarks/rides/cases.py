"""Axes of studies: scenes, with what people and chair know of each other, and local planners."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from cohelm import plugins
from cohelm.benchmarks.claims import OURS
from cohelm.benchmarks.study import Axis, Variant
from cohelm.scenarios.crowd import pedestrian_count
from cohelm.scenarios.pedestrian_spec import FlowSpec, GroupSpec, PedestrianSpec
from cohelm.scenarios.presets import tuned_settings
from cohelm.scenarios.scenario import Scenario, load_scenario

DYNAMIC = ("crossing", "aggressive", "distracted")
"""Dynamic scenes of Xu et al."""
TURNS = np.linspace(-1.9, 1.9, 20)
"""Delays of the turn of ``distracted`` relative to its file, s; seed modulo 20 selects one."""
OWN_SETTINGS = {"path_follower": ("gate.separation=false",)}
"""Settings of a planner's rides: the gate must not protect a planner that ignores people."""

TRUE_PEOPLE = "tracker.use=given"
"""Setting: the chair receives the true positions of people instead of detecting them."""

_TURNER_SPEED = 1.1
_TURNER_START, _TURNER_END = (7.5, 13.0), (7.5, 5.8)
"""As in ``distracted.yaml``, m/s and m."""


def contender_of(
    name: str, planner: str = "", settings: Iterable[str] = (), defaults: Iterable[str] = ()
) -> Variant:
    """Local planner under a name, by default its own, with settings of planner and scenario."""
    planner = planner or name
    return Variant(
        columns=(("planner", name),),
        settings=(f"local_planner.use={planner}", *settings),
        defaults=(*OWN_SETTINGS.get(planner, ()), *defaults),
    )


def planners_of(names: Iterable[str], *, tuned: bool = False) -> Axis:
    """Axis of local planners; ``tuned``: with the parameters of one search for all."""
    return tuple(
        contender_of(name, defaults=tuned_settings(name) if tuned else ()) for name in names
    )


def scene_of(scenario: str, *, blind: bool = False, true_people: bool = False) -> Variant:
    """Scenario, and how its people and the chair perceive each other.

    Args:
        scenario: name or file.
        blind: people do not see the chair, also if the scenario specifies that they do.
        true_people: the chair receives the true positions of people instead of detecting them.
    """
    sight = ("people.see_robot=false",) if blind else ()
    given = (TRUE_PEOPLE,) if true_people else ()
    stem = Path(scenario).stem if scenario.endswith((".yaml", ".yml")) else scenario
    return Variant(
        columns=(("scene", f"{stem}{', blind' if blind else ''}"),),
        settings=(*sight, *given),
        scenario=scenario,
        drawn=turn_settings if scenario == "distracted" else None,
    )


def turn_settings(seed: int) -> tuple[str, ...]:
    """Waypoints of the person of ``distracted`` for the seed's turn.

    For an early turn the person starts farther along; for a late one it walks along the wall first.
    """
    away = _TURNER_SPEED * float(TURNS[seed % len(TURNS)])
    (x, y), end = _TURNER_START, _TURNER_END
    start = [(x, y + away)] if away < 0.0 else [(x + away, y), (x, y)]
    points = [[round(float(c), 3) for c in p] for p in (*start, end, (x, y))]
    return (f"people.pedestrians=[{{points: {points}}}]",)


def scenes_of(
    names: Iterable[str],
    *,
    blind: bool = False,
    both: bool = False,
    true_people: bool = False,
    settings: tuple[str, ...] = (),
) -> Axis:
    """Axis of scenarios, each once; one whose people are blind anyway is not ridden twice.

    Args:
        names: scenarios by name or file.
        blind: see :func:`scene_of`.
        both: once as the scenario specifies, once blind.
        true_people: see :func:`scene_of`.
        settings: of every ride, which may blind the people.

    Raises:
        ScenarioError: if a scenario does not load.
    """
    out = {
        scene_of(
            name,
            blind=unseeing and _anyone_sees(load_scenario(name, settings)),
            true_people=true_people,
        ): None
        for name in dict.fromkeys(names)
        for unseeing in ((False, True) if both else (blind,))
    }
    return tuple(out)


def installed() -> tuple[str, ...]:
    """Installed local planners: ours first, those that are no rivals last."""
    names = plugins.names("local_planners")
    return tuple(sorted(names, key=lambda name: (name in OWN_SETTINGS, name != OURS, name)))


def is_rival(name: str) -> bool:
    """Check that a planner avoids people by itself."""
    return name not in OWN_SETTINGS


def rivals() -> list[str]:
    """Installed local planners that avoid people by themselves, ours among them."""
    return [name for name in installed() if is_rival(name)]


def _anyone_sees(scenario: Scenario) -> bool:
    people = scenario.people
    named: tuple[PedestrianSpec | GroupSpec | FlowSpec, ...] = (
        *people.pedestrians,
        *people.groups,
        *people.flows,
    )
    drawn = pedestrian_count(people) > pedestrian_count(people.model_copy(update={"count": None}))
    sees = [people.see_robot if each.see_robot is None else each.see_robot for each in named]
    return any(sees) or (drawn and people.see_robot)
