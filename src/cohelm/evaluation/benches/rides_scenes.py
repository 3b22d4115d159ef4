"""What is ridden: scenes with their sweeps, and who rides them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm.evaluation.company import Flow, Group, Way
from cohelm.evaluation.people import people_of
from cohelm.evaluation.scenario import Scenario, load_scenario
from cohelm.evaluation.sweeps import RideTask

DYNAMIC = ("crossing", "aggressive", "distracted")
"""The paper's dynamic scenes."""
TURNS = np.linspace(-1.9, 1.9, 20)
"""By how much the person of ``distracted`` turns back later than in its file, s; seed modulo 20."""
OWN_SETTINGS = {"path_follower": ("gate.separation=false",)}
"""What a planner is ridden with: who is blind to people is not to be saved by the gate."""

_TURNER_SPEED = 1.1
_TURNER_START, _TURNER_END = (7.5, 13.0), (7.5, 5.8)
"""As in ``distracted.yaml``, m/s and m."""


@dataclass(frozen=True)
class Contender:
    """A local planner with its settings."""

    name: str
    """In the tables."""
    planner: str
    settings: tuple[str, ...] = ()
    """``dotted.key=value``, of planner and scenario alike."""


@dataclass(frozen=True)
class Scene:
    """A scenario, and how its people and the chair know of each other."""

    scenario: str
    """A name or a file."""
    blind: bool = False
    """People do not see the chair, whatever the scenario says."""
    true_people: bool = False
    """The chair is told where people truly are, instead of its sensors' word."""
    settings: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """In the tables."""
        name = Path(self.scenario).stem if self.scenario.endswith((".yaml", ".yml")) else None
        return f"{name or self.scenario}{', blind' if self.blind else ''}"

    def settings_for(self, contender: Contender, seed: int) -> tuple[str, ...]:
        """All settings of one ride, the later ones winning."""
        sight = ("people.see_robot=false",) if self.blind else ()
        told = ("tracker.use=given",) if self.true_people else ()
        own = OWN_SETTINGS.get(contender.planner, ())
        return (*sight, *told, *self._turn(seed), *own, *self.settings, *contender.settings)

    def turn(self, seed: int) -> float:
        """By how much the turn is moved, s; NaN where the scene has none."""
        return float(TURNS[seed % len(TURNS)]) if self.scenario == "distracted" else np.nan

    def _turn(self, seed: int) -> tuple[str, ...]:
        """The way of the person of ``distracted``, walked earlier or later.

        Who is early starts farther down the way; who is late comes along the wall first.
        """
        shift = self.turn(seed)
        if np.isnan(shift):
            return ()
        away = _TURNER_SPEED * shift
        (x, y), end = _TURNER_START, _TURNER_END
        start = [(x, y + away)] if away < 0.0 else [(x + away, y), (x, y)]
        points = [[round(float(c), 3) for c in p] for p in (*start, end, (x, y))]
        return (f"people.ways=[{{points: {points}}}]",)


def scenario_of(
    scene: Scene, contender: Contender, seed: int, more: Iterable[str] = ()
) -> Scenario:
    """The scenario of one ride.

    Raises:
        ScenarioError, PluginError: see :func:`~cohelm.evaluation.scenario.load_scenario`.
    """
    settings = [*scene.settings_for(contender, seed), *more]
    return load_scenario(scene.scenario, settings, {"local_planner": contender.planner})


def ride_of(scene: Scene, contender: Contender, seed: int) -> RideTask:
    """The ride of one planner, compared by ``scene`` and ``planner``."""
    return RideTask(
        columns=(("scene", scene.label), ("planner", contender.name)),
        scenario=scene.scenario,
        settings=(
            f"local_planner.use={contender.planner}",
            *scene.settings_for(contender, seed),
        ),
        seed=seed,
    )


def comparisons(
    scenes: Sequence[Scene], contenders: Sequence[Contender], seeds: range
) -> list[tuple[RideTask, ...]]:
    """A task for each seed and scene, so that an interrupt leaves whole comparisons."""
    return [
        tuple(ride_of(scene, each, seed) for each in contenders)
        for seed in seeds
        for scene in scenes
    ]


def scenes_of(
    scenarios: Iterable[str],
    *,
    blind: bool,
    both: bool,
    true_people: bool,
    settings: tuple[str, ...] = (),
) -> tuple[Scene, ...]:
    """The scenes asked for, each in the ways of seeing that are asked for, and each once.

    A scenario whose people are blind anyway is not ridden twice.

    Raises:
        ScenarioError: if a scenario does not load.
    """
    out = []
    for name in dict.fromkeys(scenarios):
        for without_sight in (False, True) if both else (blind,):
            changed = without_sight and _anyone_sees(load_scenario(name, settings))
            out.append(
                Scene(scenario=name, blind=changed, true_people=true_people, settings=settings)
            )
    return tuple(dict.fromkeys(out))


def _anyone_sees(scenario: Scenario) -> bool:
    people = scenario.people
    named: tuple[Way | Group | Flow, ...] = (*people.ways, *people.groups, *people.flows)
    drawn = people_of(people) > people_of(people.model_copy(update={"count": None}))
    sees = [people.see_robot if each.see_robot is None else each.see_robot for each in named]
    return any(sees) or (drawn and people.see_robot)
