"""Arrivals, collisions and calmness of ``ss_mpc_dcbf``: hospital, real floors, narrow floors.

Parts: ``hospital`` with people who see the chair; ``blind``, the same with people who do not;
``floors``, random rides on the maps in COHELM_DATA; ``narrow``, three fixed rides through narrow
passages of one of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from cohelm.benchmarks.bench import Result, chosen_names, known_name, missing_data, unset
from cohelm.benchmarks.options import Modes, Settings, repeatable
from cohelm.benchmarks.rides.calm_report import calm_report
from cohelm.benchmarks.rides.false_alarms import AlarmWatch
from cohelm.benchmarks.rides.floor_draws import (
    SCENARIO,
    FloorDraw,
    draw_ride,
    floor_settings,
    known_floor,
)
from cohelm.benchmarks.study import Study
from cohelm.errors import ConfigError
from cohelm.evaluation import run
from cohelm.evaluation.episode.ride import Ride
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.messages import Mode
from cohelm.navigation import Tick
from cohelm.recordings.outside_data import outside_file
from cohelm.scenarios import Scenario
from cohelm.simulation import GroundTruth

TITLE = "Arrivals and calmness of the chair"
AUTONOMOUS, SHARED = Mode.AUTONOMOUS.value, Mode.SHARED.value
RIDER = "noisy"
"""Rider in shared control: steers to the destination with random input from time to time."""
MAPS = "ros_maps"
"""Folder of the floors in COHELM_DATA."""
NARROW_FLOOR = "utexas_gdc_3ne"
NARROW = (
    ("29 m", 0, FloorDraw((-56.48, -6.37), (-27.43, -4.77), people=12, time_limit=180.0)),
    ("29 m", 1, FloorDraw((-56.48, -6.37), (-27.43, -4.77), people=12, time_limit=180.0)),
    ("15 m", 0, FloorDraw((-51.68, -11.42), (-36.78, -7.82), people=10, time_limit=180.0)),
)
"""Name, seed and ride of each narrow ride."""


@dataclass(frozen=True)
class RidePart:
    """Part of the benchmark."""

    seeds: int
    """Largest number of seeds; for ``floors``, on each of them."""
    modes: tuple[str, ...] = (AUTONOMOUS,)
    settings: tuple[str, ...] = ()
    needs_maps: bool = False


PARTS: Mapping[str, RidePart] = {
    "hospital": RidePart(40, (AUTONOMOUS, SHARED)),
    "blind": RidePart(20, settings=("people.see_robot=false",)),
    "floors": RidePart(8, needs_maps=True),
    "narrow": RidePart(1, needs_maps=True),
}


class Case(NamedTuple):
    """A ride apart from its mode."""

    scene: str
    seed: int
    file: Path | None = None
    """Map; None: the floor of the scenario."""
    draw: FloorDraw | None = None
    """Start and goal on the map; None: those that the seed draws."""


def _plan(
    parts: Sequence[str],
    share: float,
    modes: Sequence[str],
    settings: tuple[str, ...],
    seeds: range,
) -> list[tuple[RideTask]]:
    """One task per ride: part by part, in each part seed by seed."""
    return [
        (
            RideTask(
                columns=(("part", name), ("scene", case.scene), ("mode", mode)),
                scenario=SCENARIO,
                settings=(
                    f"mode={mode}",
                    *(() if mode == AUTONOMOUS else (f"rider.use={RIDER}",)),
                    *PARTS[name].settings,
                    *placed,
                    *settings,
                ),
                seed=case.seed,
            ),
        )
        for name in parts
        for case in _some(cases_of(name, seeds[: PARTS[name].seeds]), share)
        if (placed := _placed(case)) is not None
        for mode in modes or PARTS[name].modes
    ]


def _some(cases: list[Case], share: float) -> list[Case]:
    """First cases: a share of them, but one at least."""
    return cases[: max(1, math.ceil(share * len(cases)))]


def cases_of(part: str, seeds: range) -> list[Case]:
    """Rides of a part, apart from their modes; those of ``narrow`` are the same for all seeds.

    Raises:
        ConfigError: if its maps are missing.
    """
    if part == "floors":
        return [Case(file.stem, seed, file) for seed in seeds for file in floor_files()]
    if part == "narrow":
        file = next((each for each in floor_files() if each.stem == NARROW_FLOOR), None)
        if file is None:
            raise ConfigError(missing_data(MAPS, f"{NARROW_FLOOR}.yaml"), key="--part")
        return [Case(f"{NARROW_FLOOR}, {name}", seed, file, draw) for name, seed, draw in NARROW]
    return [Case(SCENARIO, seed) for seed in seeds]


def floor_files() -> list[Path]:
    """Maps in COHELM_DATA, by name.

    Raises:
        ConfigError: if there are none.
    """
    folder = outside_file(MAPS)
    files = sorted(folder.glob("*.yaml")) if folder is not None else []
    if not files:
        raise ConfigError(missing_data(MAPS), key="--part")
    return [file.absolute() for file in files]


def create(
    part: Annotated[
        tuple[str, ...],
        repeatable("--part", "NAME", "hospital, blind, floors or narrow; default: all"),
    ] = (),
    modes: Modes = None,
    share: Annotated[
        float, typer.Option(min=0.001, max=1.0, help="Share of the usual number of rides.")
    ] = 1.0,
    settings: Settings = (),
) -> Study:
    """Create the study from its options; without parts, all whose data there is.

    Raises:
        ConfigError, PluginError, ScenarioError: if a part, a mode or a setting does not exist, or
            the maps of a part that is named are missing.
    """
    drawn = dict.fromkeys(("start", "goal", "map", "floor"), "the seed")
    unset(settings, {"mode": "--modes", "people.see_robot": "--part", **drawn})
    known = [each.value for each in Mode]
    driven = chosen_names(modes, "--modes", (), kind="mode", known=known)
    for name in part:
        known_name(name, tuple(PARTS), "part", "--part")
    there = outside_file(MAPS) is not None
    parts = tuple(dict.fromkeys(part)) or tuple(
        name for name, each in PARTS.items() if there or not each.needs_maps
    )
    if any(PARTS[name].needs_maps for name in parts):
        floor_files()
    check_rides([(RideTask((), SCENARIO, tuple(settings), 0),)], "local_planner")
    plan = partial(_plan, parts, share, driven, tuple(settings))
    return Study(TITLE, plan, partial(calm_report, title=TITLE), _rides, SEEDS=40)


def _rides(task: Sequence[RideTask]) -> list[Result]:
    return [_row(each) for each in task]


def _row(task: RideTask) -> Result:
    """Ride, and count the false alarms where no fault was set."""
    watch = AlarmWatch()

    def drive(scenario: Scenario, seed: int) -> Ride:
        def see(tick: Tick, truth: GroundTruth) -> None:
            watch.see(tick, truth)

        return run(scenario, seed, see)

    def more(ride: Ride) -> Mapping[str, Any]:
        return {} if ride.scenario.faults else watch.columns(ride)

    return ride_row(task, empty_floor=False, more=more, drive=drive)


def _placed(case: Case) -> tuple[str, ...] | None:
    """Settings of start, goal and map; None where the floor is too small for a ride."""
    if case.file is None:
        return ()
    draw = case.draw or draw_ride(case.file, _known_floor(case.file), case.seed)
    return None if draw is None else floor_settings(case.file, draw)


_known_floor = lru_cache(maxsize=32)(known_floor)
