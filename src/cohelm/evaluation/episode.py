"""One ride: the only place where a world and a navigator meet."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.noting import Stops, row_of, states_of
from cohelm.evaluation.ride import GOAL_RADIUS, Outcome, Replan, Ride
from cohelm.evaluation.scenario import Scenario
from cohelm.evaluation.staging import Stage, set_stage
from cohelm.messages import Path
from cohelm.navigation import Navigator, Tick
from cohelm.simulation import Truth, World, is_standing

SETTLING = 2.0
"""After coming within the goal's radius the chair must stand still within this, s."""
PATIENCE = 20.0
"""A chair that has stood for longer, whatever the reason, has stopped, s."""
KEPT = 0.5
"""Between the ticks that are kept for pictures, s."""

Watcher = Callable[[Tick, Truth], None]
"""Called after every tick with what was decided and how things were."""


def run(scenario: Scenario, seed: int, on_tick: Watcher | None = None) -> Ride:
    """Ride a scenario; the same scenario and seed give the same ride bit for bit, durations apart.

    Raises:
        ConfigError, MapError, PluginError, PlanningError: see :func:`~.staging.set_stage`.
    """
    return Episode(set_stage(scenario, seed)).run(on_tick)


class Episode:
    """A ride in the making.

    Args:
        stage: everything it needs.
    """

    def __init__(self, stage: Stage) -> None:
        self.stage = stage

    def run(self, on_tick: Watcher | None = None) -> Ride:
        """Ride to the end: goal, collision, stop or time limit."""
        stage = self.stage
        world = World(stage.world, stage.seed)
        navigator = Navigator(stage.navigator)
        log = _Log()
        tick: Tick | None = None
        while True:
            truth = world.truth
            tick = navigator.step(world.observe(), stage.request, tick)
            log.add(truth, tick)
            if on_tick is not None:
                on_tick(tick, truth)
            outcome = log.outcome(stage)
            if outcome is not None:
                return log.ride(stage, outcome)
            world.advance(tick.decision)


class _Log:
    """What has happened so far."""

    def __init__(self) -> None:
        self.truths: list[Truth] = []
        self.rows: list[Floats] = []
        self.durations: list[dict[str, float]] = []
        self.kept: list[Tick] = []
        self.closest: tuple[float, Tick] | None = None
        self.stops = Stops()
        self.replans: list[Replan] = []
        self._path: Path | None = None
        self.first: Tick | None = None
        self._entered: float | None = None

    def add(self, truth: Truth, tick: Tick) -> None:
        """One tick: how things were, and what the navigator made of what it was told."""
        self.truths.append(truth)
        self.rows.append(row_of(tick))
        self.durations.append(dict(tick.durations))
        self.first = self.first or tick
        if not self.kept or truth.time - self.kept[-1].observation.time > KEPT - 1e-9:
            self.kept.append(tick)
        gap = float(truth.gap_people.min(initial=np.inf))
        if np.isfinite(gap) and (self.closest is None or gap < self.closest[0]):
            self.closest = gap, tick
        self.stops.add(truth, tick)
        self._note_path(truth, tick)

    def _note_path(self, truth: Truth, tick: Tick) -> None:
        """A path that is not the last one replaces it, but for the first of all."""
        route = tick.memory.route
        if route is None or route.path is self._path:
            return
        if self._path is not None:
            found = Replan(time=truth.time, why=route.why, points=route.path.points)
            self.replans.append(found)
        self._path = route.path

    def outcome(self, stage: Stage) -> Outcome | None:
        """How the ride has ended; None: it goes on."""
        truth = self.truths[-1]
        if truth.hit_moving.any() or truth.hit_wall:
            return Outcome.COLLISION
        if np.hypot(*(truth.pose[:2] - stage.request.goal)) > GOAL_RADIUS:
            self._entered = None
        else:
            self._entered = truth.time if self._entered is None else self._entered
            in_time = truth.time - self._entered <= SETTLING + 1e-9
            if in_time and bool(is_standing(truth.twist)):
                return Outcome.REACHED
        if self.stops.standing(truth.time) > PATIENCE:
            return Outcome.STOPPED
        if truth.time >= stage.scenario.time_limit - 1e-9:
            return Outcome.TIMEOUT
        return None

    def ride(self, stage: Stage, outcome: Outcome) -> Ride:
        """All of it as one value."""
        truths, rows = self.truths, np.array(self.rows)
        k, n = len(truths), len(truths[0].crowd.radius)
        people = [states_of(t.crowd) for t in truths]
        return Ride(
            scenario=stage.scenario,
            seed=stage.seed,
            outcome=outcome,
            robot=stage.robot,
            grid=stage.grid,
            world=stage.world.grid,
            places=stage.places,
            goal=stage.request.goal,
            prefer=stage.prefer,
            step=stage.world.control_step,
            time=np.array([t.time for t in truths]),
            pose=np.array([t.pose for t in truths]),
            twist=np.array([t.twist for t in truths]),
            command=rows[:, :3],
            asked=rows[:, 3:6],
            stick=rows[:, 6:8],
            eta=rows[:, 8],
            gap_people=np.array([t.gap_people for t in truths]).reshape(k, n),
            gap_wall=np.array([t.gap_wall for t in truths]),
            hit_moving=np.array([t.hit_moving for t in truths]).reshape(k, n),
            hit_standing=np.array([t.hit_standing for t in truths]).reshape(k, n),
            hit_wall=np.array([t.hit_wall for t in truths]),
            people=np.array(people).reshape(k, n, 4),
            people_heading=np.array([t.crowd.heading for t in truths]).reshape(k, n),
            people_target=np.array([t.crowd.target for t in truths]).reshape(k, n),
            people_radius=truths[0].crowd.radius,
            people_see=truths[0].crowd.sees_robot,
            setup=stage.world,
            stops=tuple(self.stops.all),
            path=self.first.path if self.first is not None else None,
            replans=tuple(self.replans),
            ticks=tuple(self.kept),
            closest=self.closest[1] if self.closest is not None else None,
            durations=_by_stage(self.durations),
        )


def _by_stage(durations: list[dict[str, float]]) -> MappingProxyType[str, Floats]:
    """Durations (k,) of each stage, 0 where it did not run, and the whole tick's."""
    stages = sorted({stage for each in durations for stage in each} - {"tick"})
    by_stage = {s: np.array([each.get(s, 0.0) for each in durations]) for s in stages}
    whole = np.sum(list(by_stage.values()), axis=0) if by_stage else np.zeros(len(durations))
    return MappingProxyType({**by_stage, "tick": whole})
