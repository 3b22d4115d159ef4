"""Scenes and contenders of benchmarks, and the rides that they make."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm import plugins
from cohelm.benchmarks.claims import OURS
from cohelm.evaluation.sweeps import RideTask
from cohelm.scenarios.crowd import pedestrian_count
from cohelm.scenarios.pedestrian_spec import FlowSpec, GroupSpec, PedestrianSpec
from cohelm.scenarios.scenario import Scenario, load_scenario

DYNAMIC = ("crossing", "aggressive", "distracted")
"""Dynamic scenes of Xu et al."""
TURNS = np.linspace(-1.9, 1.9, 20)
"""Delays of the turn of ``distracted`` relative to its file, s; seed modulo 20 selects one."""
OWN_SETTINGS = {"path_follower": ("gate.separation=false",)}
"""Settings of a planner's rides: the gate must not protect a planner that ignores people."""

_TURNER_SPEED = 1.1
_TURNER_START, _TURNER_END = (7.5, 13.0), (7.5, 5.8)
"""As in ``distracted.yaml``, m/s and m."""


@dataclass(frozen=True)
class Contender:
    """A local planner with its settings."""

    name: str
    """Name in the tables."""
    planner: str
    settings: tuple[str, ...] = ()
    """``dotted.key=value`` of planner and scenario alike."""


@dataclass(frozen=True)
class BenchScene:
    """A scenario, and how its people and the chair perceive each other."""

    scenario: str
    """Name or file."""
    blind: bool = False
    """People do not see the chair, also if the scenario specifies that they do."""
    true_people: bool = False
    """The chair receives the true positions of people instead of detecting them."""
    settings: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name in the tables."""
        name = Path(self.scenario).stem if self.scenario.endswith((".yaml", ".yml")) else None
        return f"{name or self.scenario}{', blind' if self.blind else ''}"

    def settings_for(self, contender: Contender, seed: int) -> tuple[str, ...]:
        """All settings of one ride; later ones override earlier ones."""
        sight = ("people.see_robot=false",) if self.blind else ()
        given = ("tracker.use=given",) if self.true_people else ()
        own = OWN_SETTINGS.get(contender.planner, ())
        return (*sight, *given, *self._turn(seed), *own, *self.settings, *contender.settings)

    def turn(self, seed: int) -> float:
        """Delay of the turn, s; NaN in a scene without one."""
        return float(TURNS[seed % len(TURNS)]) if self.scenario == "distracted" else np.nan

    def _turn(self, seed: int) -> tuple[str, ...]:
        """Waypoints of the person of ``distracted`` for the seed's turn.

        For an early turn the person starts farther along; for a late one it walks along the wall
        first.
        """
        shift = self.turn(seed)
        if np.isnan(shift):
            return ()
        away = _TURNER_SPEED * shift
        (x, y), end = _TURNER_START, _TURNER_END
        start = [(x, y + away)] if away < 0.0 else [(x + away, y), (x, y)]
        points = [[round(float(c), 3) for c in p] for p in (*start, end, (x, y))]
        return (f"people.pedestrians=[{{points: {points}}}]",)


def scenario_of(
    scene: BenchScene, contender: Contender, seed: int, more: Iterable[str] = ()
) -> Scenario:
    """Load the scenario of one ride.

    Raises:
        ScenarioError, PluginError: see :func:`~cohelm.scenarios.scenario.load_scenario`.
    """
    settings = [*scene.settings_for(contender, seed), *more]
    return load_scenario(scene.scenario, settings, {"local_planner": contender.planner})


def ride_of(scene: BenchScene, contender: Contender, seed: int) -> RideTask:
    """Ride of one contender, compared by ``scene`` and ``planner``."""
    return RideTask(
        columns=(("scene", scene.label), ("planner", contender.name)),
        scenario=scene.scenario,
        settings=(f"local_planner.use={contender.planner}", *scene.settings_for(contender, seed)),
        seed=seed,
    )


def comparisons(
    scenes: Sequence[BenchScene], contenders: Sequence[Contender], seeds: range
) -> list[tuple[RideTask, ...]]:
    """One task per seed and scene, so that an interrupt leaves complete comparisons."""
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
) -> tuple[BenchScene, ...]:
    """Requested scenes, each once; a scenario whose people are blind anyway is not ridden twice.

    Args:
        scenarios: names or files.
        blind: people do not see the chair.
        both: once as the scenario specifies, once blind.
        true_people: see :class:`BenchScene`.
        settings: of every ride.

    Raises:
        ScenarioError: if a scenario does not load.
    """
    out = []
    for name in dict.fromkeys(scenarios):
        for without_sight in (False, True) if both else (blind,):
            changed = without_sight and _anyone_sees(load_scenario(name, settings))
            out.append(
                BenchScene(scenario=name, blind=changed, true_people=true_people, settings=settings)
            )
    return tuple(dict.fromkeys(out))


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
