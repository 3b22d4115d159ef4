"""Faults of sensors, wheels and stick: each ride paired with the same ride without the fault."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

from cohelm.benchmarks.bench import Result, chosen_names, known_name, unset
from cohelm.benchmarks.options import Modes, Scenes, Settings, flag, names
from cohelm.benchmarks.rides.cases import scenes_of
from cohelm.benchmarks.rides.false_alarms import INPUT_REASONS, AlarmWatch
from cohelm.benchmarks.rides.fault_report import fault_report
from cohelm.benchmarks.rides.modes import MODES
from cohelm.benchmarks.study import Axis, Grid, Study, Variant, axis, common
from cohelm.errors import ConfigError
from cohelm.evaluation.episode.episode import Course
from cohelm.evaluation.episode.ride import Ride
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.messages import Mode
from cohelm.navigation import Navigator, Tick
from cohelm.platforms import PlanarPlatform
from cohelm.scenarios import RideSetup, Scenario, build_scenario
from cohelm.simulation import FAULT_KINDS, Fault, GroundTruth, World, generator, is_standing

TITLE = "Faults: detection, stopping and contacts"
SCENES = ("crossing", "narrow-doorway")
DRIVEN = (Mode.AUTONOMOUS.value, Mode.STOP_ONLY.value)
ONSET = (2.0, 4.0)
"""Range of the onset, s: the chair is under way."""
LASTING = 8.0
"""Longest time from the onset to the end of a ride, s."""
STOOD = 3.0
"""Time of standing for a finding after which a ride ends, s: three times the longest time after
which a finding that is gone ends, so the finding has been made again meanwhile."""
NONE = "none"
"""Column ``fault`` of rides without one."""
COMPARED = {
    "faults": "--faults",
    "mode": "--modes",
    "rider": "--modes",
    "time_limit": "the seed",
    "health.enabled": "--unwatched",
    "people.see_robot": "the benchmark, in which nobody sees the chair",
}
"""Keys that cannot be set for all rides → what sets them."""


class FaultCase(NamedTuple):
    """Fault of one magnitude; NaN: its kind has none."""

    kind: str
    magnitude: float = math.nan


class FaultStart:
    """Ride up to the onset, which all faults of a seed share.

    Args:
        onset: s.
    """

    def __init__(self, onset: float) -> None:
        self._onset = onset
        self._begun: _Begun | None = None
        self._watch = FaultWatch(onset)

    def columns(self, ride: Ride) -> Mapping[str, Any]:
        """Columns of the ride that was driven last."""
        return self._watch.columns(ride)

    def drive(self, scenario: Scenario, seed: int) -> Ride:
        """Ride a scenario; before the onset, only the first call drives."""
        begun = self._begun = self._begun or self._begin(scenario, seed)
        self._watch = copy.deepcopy(begun.watch)
        if begun.ended is not None:
            return replace(begun.ended, scenario=scenario)
        world = begun.world.branch(scenario.faults)
        setup = replace(begun.setup, scenario=scenario, world=world.setup)
        course = begun.course.branch(setup, PlanarPlatform(world), world)
        return course.run(self._watch.see)

    def _begin(self, scenario: Scenario, seed: int) -> _Begun:
        """Ride to the last step before the onset; with a fault, the world keeps its input."""
        later = Fault(kind="people_swapped", at=1e6)
        setup = build_scenario(scenario.model_copy(update={"faults": (later,)}), seed)
        world, watch = World(setup.world, seed), FaultWatch(self._onset)
        course = Course(setup, PlanarPlatform(world), world, Navigator(setup.navigator))
        ended: Ride | None = None
        while ended is None and world.truth.time < self._onset - 1.5 * setup.world.control_step:
            ended = course.step(watch.see)
        return _Begun(setup, world, course, watch, ended)


class _Begun(NamedTuple):
    """Ride up to the onset."""

    setup: RideSetup
    world: World
    course: Course
    watch: FaultWatch
    ended: Ride | None
    """The whole ride, where it ended before the onset."""


class FaultWatch:
    """First detection and the course of a ride from the onset on.

    Args:
        onset: of the fault, s.
    """

    def __init__(self, onset: float) -> None:
        self._onset = onset
        self._found: tuple[float, str] | None = None
        self._alarms = AlarmWatch()
        self._stands_since: float | None = None
        self._walked_into = False

    def see(self, tick: Tick, truth: GroundTruth) -> bool:
        """Look at a tick for findings of the monitor and reasons of the gate.

        Returns:
            True if the rest of the ride decides nothing: the chair stands because of a finding, or
            a person has walked into the standing chair and would now walk through it.
        """
        reasons = self._alarms.see(tick, truth)
        if reasons and self._found is None and truth.time >= self._onset - 1e-9:
            self._found = truth.time, reasons[0]
        self._walked_into = self._walked_into or bool(truth.hit_standing.any())
        stopped = tick.health.stop is not None or tick.decision.reason in INPUT_REASONS
        if not (stopped and self._found is not None and bool(is_standing(truth.twist))):
            self._stands_since = None
        elif self._stands_since is None:
            self._stands_since = truth.time
        stood = self._stands_since is not None and truth.time - self._stands_since >= STOOD - 1e-9
        return stood or self._walked_into

    def columns(self, ride: Ride) -> Mapping[str, Any]:
        """Columns of the benchmark."""
        after = ride.time >= self._onset - 1e-9
        touched = (ride.hit_moving.any(axis=1) | ride.hit_wall) & after
        speed = np.hypot(ride.twist[:, 0], ride.twist[:, 1])
        fastest = np.maximum(speed, np.concatenate([[0.0], speed[:-1]]))
        found = math.nan if self._found is None else self._found[0] - self._onset
        return {
            "onset": self._onset,
            **self._alarms.columns(ride),
            "noticed": float(self._found is not None),
            "delay": found,
            "largest_step": _largest_step(ride),
            "walked_into": float(self._walked_into),
            "noticed_by": "" if self._found is None else self._found[1],
            **_stop(ride, after, self._onset),
            "contact_speed": float(fastest[touched].max()) if touched.any() else 0.0,
        }


def _largest_step(ride: Ride) -> float:
    """Longest way between two ticks, m: of a chair that was carried, that of the carry."""
    return float(np.hypot(*np.diff(ride.pose[:, :2], axis=0).T).max(initial=0.0))


def _stop(ride: Ride, after: np.ndarray, onset: float) -> Mapping[str, float]:
    """Time and distance from the onset to the first standstill; NaN without one."""
    stands = np.flatnonzero(after & np.asarray(is_standing(ride.twist)))
    if not len(stands):
        return {"stop_time": math.nan, "stop_distance": math.nan}
    begin, end = int(np.argmax(after)), int(stands[0])
    way = np.hypot(*np.diff(ride.pose[begin : end + 1, :2], axis=0).T).sum()
    return {"stop_time": float(ride.time[end] - onset), "stop_distance": float(way)}


def cases_of(kinds: Sequence[str]) -> list[FaultCase]:
    """Cases of ``KIND:MAGNITUDE``, and every magnitude of a kind that is named alone."""
    out = []
    for given in kinds:
        kind, _, size = given.partition(":")
        usual = FAULT_KINDS[kind].intensities or (math.nan,)
        out += [FaultCase(kind, each) for each in ((float(size),) if size else usual)]
    return out


def _onset(seed: int) -> float:
    """Onset of the faults of a seed, s, on a tick."""
    return round(float(generator(seed, "fault onset").uniform(*ONSET)) / 0.05) * 0.05


def fault_axis(kinds: Sequence[str]) -> Axis:
    """Axis of a sound ride and of the cases of ``kinds``, each from the seed's onset on."""
    return tuple(
        Variant((("fault", kind), ("magnitude", f"{size:g}")), drawn=partial(_fault, kind, size))
        for kind, size in (FaultCase(NONE), *cases_of(kinds))
    )


def _fault(kind: str, magnitude: float, seed: int) -> tuple[str, ...]:
    if kind == NONE:
        return ()
    size = "" if math.isnan(magnitude) else f", magnitude: {magnitude:.6f}"
    return (f"faults=[{{kind: {kind}, at: {_onset(seed):g}, duration: 100{size}}}]",)


def _time_limit(seed: int) -> tuple[str, ...]:
    return (f"time_limit={_onset(seed) + LASTING}",)


def _driven(mode: str) -> Variant:
    """Mode, with a noisy rider but where the chair drives alone."""
    rider = "none" if mode == Mode.AUTONOMOUS.value else "noisy"
    return Variant((("mode", mode),), (f"mode={mode}", f"rider.use={rider}"))


def ride_faults(task: Sequence[RideTask]) -> list[Result]:
    """Ride once up to the onset, and from there on with each fault."""
    start = FaultStart(_onset(task[0].seed))
    rides = [
        ride_row(each, empty_floor=False, more=start.columns, drive=start.drive) for each in task
    ]
    return [Result(each.row) for each in rides]


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def create(
    kinds: Annotated[
        str | None,
        names("Kinds, or KIND:MAGNITUDE; default: all but cloud_*.", "--faults"),
    ] = None,
    scenes: Scenes = None,
    modes: Modes = None,
    *,
    unwatched: Annotated[
        bool, flag("--unwatched", "Ride again without the health monitor.")
    ] = False,
    settings: Settings = (),
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, ScenarioError: if a fault, scene, mode or setting does not exist.
    """
    unset(settings, COMPARED)
    sensed = [
        kind for kind in FAULT_KINDS if not kind.startswith("cloud_")
    ]  # its chairs have no 3-D sensor
    named = chosen_names(kinds, "--faults", sensed)
    for name in named:
        kind, _, size = name.partition(":")
        known_name(kind, tuple(FAULT_KINDS), "fault", "--faults")
        if size and not _is_number(size):
            raise ConfigError(f"the magnitude of {name!r} is not a number", key="--faults")
        refusal = FAULT_KINDS[kind].refusal(kind, float(size)) if size else ""
        if refusal:
            raise ConfigError(refusal, key="--faults")
    driven = chosen_names(modes, "--modes", DRIVEN, kind="mode", known=MODES)
    monitors: dict[str, Sequence[str]] = {"on": ()}
    if unwatched:
        monitors["off"] = ("health.enabled=false",)
    plan = Grid(
        (
            scenes_of(chosen_names(scenes, "--scenes", SCENES)),
            tuple(map(_driven, driven)),
            (Variant(settings=("people.see_robot=false",), drawn=_time_limit),),
            axis("monitor", monitors),
            common(settings),
            fault_axis(named),
        )
    )
    return Study(TITLE, plan, fault_report, ride_faults, SEEDS=5).checked("rider")
