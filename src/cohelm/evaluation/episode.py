"""One ride: the only place where a world and a navigator meet."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.ride import GOAL_RADIUS, Outcome, Replan, Ride, Stop
from cohelm.evaluation.scenario import Scenario
from cohelm.evaluation.staging import Stage, set_stage
from cohelm.messages import Path, Reason
from cohelm.navigation import Navigator, Tick
from cohelm.simulation import Crowd, Truth, World, is_standing

SETTLING = 2.0
"""After coming within the goal's radius the chair must stand still within this, s."""
PATIENCE = 20.0
"""A chair that has stood for longer, whatever the reason, has stopped, s."""
ONE_STOP = 1.0
"""Between the end of a stop and the beginning of another, s; less is the same stop."""
KEPT = 0.5
"""Between the ticks that are kept for pictures, s."""

Watcher = Callable[[Tick, Truth], None]
"""Called after every tick with what was decided and how things were."""

_NOT_A_STOP = frozenset(
    {
        Reason.OVER_LIMITS,
        Reason.TOO_CLOSE,
        Reason.ARRIVED,
        Reason.BACKING_UP,
        Reason.CREEPING,
    }
)
"""Reasons with which the chair goes on, or rightly stands: no stop is noted."""


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
        self.stops: list[Stop] = []
        self.replans: list[Replan] = []
        self._path: Path | None = None
        self.first: Tick | None = None
        self._entered: float | None = None
        self._stood_since: float | None = None

    def add(self, truth: Truth, tick: Tick) -> None:
        """One tick: how things were, and what the navigator made of what it was told."""
        self.truths.append(truth)
        self.rows.append(_row(tick))
        self.durations.append(dict(tick.durations))
        self.first = self.first or tick
        if not self.kept or truth.time - self.kept[-1].observation.time > KEPT - 1e-9:
            self.kept.append(tick)
        gap = float(truth.gap_people.min(initial=np.inf))
        if np.isfinite(gap) and (self.closest is None or gap < self.closest[0]):
            self.closest = gap, tick
        self._note_stop(truth, tick)
        self._note_standing(truth, tick)
        self._note_path(truth, tick)

    def _note_stop(self, truth: Truth, tick: Tick) -> None:
        """Two stops less than a second apart are one, with the first's reason."""
        reason = tick.decision.reason
        if reason is None or reason in _NOT_A_STOP:
            return
        last = self.stops[-1] if self.stops else None
        if last is None or truth.time - (last.time + last.duration) > ONE_STOP:
            begun = Stop(time=truth.time, duration=0.0, reason=reason, detail=tick.trouble)
            self.stops.append(begun)
        else:
            self.stops[-1] = dataclasses.replace(last, duration=truth.time - last.time)

    def _note_standing(self, truth: Truth, tick: Tick) -> None:
        """Since when the chair stands; at its goal it may."""
        if not bool(is_standing(truth.twist)) or tick.decision.reason is Reason.ARRIVED:
            self._stood_since = None
        elif self._stood_since is None:
            self._stood_since = truth.time

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
        if self._stood_since is not None and truth.time - self._stood_since > PATIENCE:
            return Outcome.STOPPED
        if truth.time >= stage.scenario.time_limit - 1e-9:
            return Outcome.TIMEOUT
        return None

    def ride(self, stage: Stage, outcome: Outcome) -> Ride:
        """All of it as one value."""
        truths, rows = self.truths, np.array(self.rows)
        k, n = len(truths), len(truths[0].crowd.radius)
        people = [_states(t.crowd) for t in truths]
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
            stops=tuple(self.stops),
            path=self.first.path if self.first is not None else None,
            replans=tuple(self.replans),
            ticks=tuple(self.kept),
            closest=self.closest[1] if self.closest is not None else None,
            durations=_by_stage(self.durations),
        )


def _states(crowd: Crowd) -> Floats:
    """(x, y, v_x, v_y) of each, (n, 4); NaN for who is not there."""
    states = np.column_stack([crowd.position, crowd.velocity])
    return np.where(crowd.there[:, None], states, np.nan)


def _row(tick: Tick) -> Floats:
    """(command 3, asked 3, stick 2, η) of one tick; NaN where there is no device."""
    authority, rider = tick.authority, tick.observation.rider
    there = authority is not None and rider is not None
    return np.concatenate(
        [
            tick.decision.twist,
            authority.twist if authority is not None and there else np.full(3, np.nan),
            rider.deflection if rider is not None else np.full(2, np.nan),
            [authority.eta if authority is not None else 0.0],
        ]
    )


def _by_stage(durations: list[dict[str, float]]) -> MappingProxyType[str, Floats]:
    """Durations (k,) of each stage, 0 where it did not run, and the whole tick's."""
    stages = sorted({stage for each in durations for stage in each} - {"tick"})
    by_stage = {s: np.array([each.get(s, 0.0) for each in durations]) for s in stages}
    whole = np.sum(list(by_stage.values()), axis=0) if by_stage else np.zeros(len(durations))
    return MappingProxyType({**by_stage, "tick": whole})
