"""``cohelm run``: from the options to a scenario, a ride, and what is written about it."""

from __future__ import annotations

import csv
import math
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.cli import words
from cohelm.cli.progress import RideProgress
from cohelm.cli.report import ERRORS, OUTPUT, as_json, metrics_table, versions, write_json
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.evaluation import Outcome, Ride, Scenario, load_scenario, measure, timing
from cohelm.evaluation import run as ride_out
from cohelm.evaluation.people import people_of
from cohelm.evaluation.scenario import PARTS
from cohelm.plugins import names

PEOPLE_ON_A_MAP = 12
"""On a map of one's own, where the scenario has nobody to bring along."""


@dataclass(frozen=True)
class Asked:
    """What the options say of the ride; None: what the scenario says."""

    scenario: str
    map: str | None = None
    start: str | None = None
    goal: str | None = None
    prefer: tuple[str, ...] = ()
    people: int | None = None
    planner: str | None = None
    method: str | None = None
    robot: str | None = None
    rider: str | None = None
    mode: str | None = None
    seed: int | None = None
    settings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outputs:
    """What is to be written, and where."""

    out: Path | None = None
    json: bool = False
    plot: Path | None = None
    animate: Path | None = None
    record: Path | None = None
    quiet: bool = False


def run(asked: Asked, outputs: Outputs) -> int:
    """Ride; returns 0 where the goal was reached, else 1.

    Raises:
        CohelmError: if what was asked cannot be done.
    """
    _check_outputs(outputs)
    scenario = scenario_of(asked)
    seed = scenario.seed if asked.seed is None else asked.seed
    where = "" if asked.map is None else f" on {Path(asked.map).stem}"
    title = f"{scenario.name}{where}, seed {seed}"
    began = time.monotonic()
    with RideProgress(title, scenario.time_limit, shown=not outputs.quiet) as progress:
        ride = _ridden(scenario, seed, progress, outputs.record)
    wall_time = time.monotonic() - began
    report = summary(ride, wall_time)
    _write_pictures(ride, report, title, outputs)
    if outputs.out is not None:
        _write_folder(ride, report, outputs.out)
    _say(ride, report, title, outputs)
    return 0 if ride.outcome is Outcome.REACHED else 1


def _ridden(scenario: Scenario, seed: int, progress: RideProgress, record: Path | None) -> Ride:
    if record is None:
        return ride_out(scenario, seed, progress)
    from cohelm.evaluation.recorded import run_recorded  # noqa: PLC0415 # lazy

    return run_recorded(scenario, seed, record, progress)


def scenario_of(asked: Asked) -> Scenario:
    """The scenario with the options put in; ``--set`` comes last.

    Raises:
        ConfigError, ScenarioError: naming the option or the key.
    """
    base = load_scenario(asked.scenario)
    changes: dict[str, Any] = _onto_map(base, asked) if asked.map is not None else {}
    if asked.start is not None:
        changes["start"] = words.place(asked.start, "--start", heading=True)
    if asked.goal is not None:
        changes["goal"] = words.place(asked.goal, "--goal")
    if asked.prefer:
        changes["prefer"] = [words.point(text, "--prefer") for text in asked.prefer]
    if asked.robot is not None:
        changes["robot"] = _robot(asked.robot)
    if asked.mode is not None:
        changes["mode"] = asked.mode
    parts = {
        "local_planner": ("--planner", asked.planner),
        "global_planner": ("--method", asked.method),
        "rider": ("--rider", asked.rider),
    }
    for key, (option, name) in parts.items():
        if name is not None and name != getattr(base, key)["use"]:
            _check_installed(PARTS[key][0], name, option)
            changes[key] = {"use": name}
    settings = [] if asked.people is None else [f"people.count={asked.people}"]
    return load_scenario(asked.scenario, [*settings, *asked.settings], changes)


def check_record(file: Path) -> None:
    """Refuse to write over a ride that somebody has, or where nothing can be written.

    Raises:
        ConfigError: saying which.
    """
    if file.suffix.lower() != ".mcap":
        raise ConfigError(f"{file}: write a recording as FILE.mcap", key="--record")
    if file.exists():
        raise ConfigError(f"{file} exists already; name another file", key="--record")
    if not file.absolute().parent.is_dir():
        raise ConfigError(f"{file.parent} is no folder to write to", key="--record")


def summary(ride: Ride, wall_time: float) -> dict[str, Any]:
    """What ``--json`` says: metrics by name, the outcome, every duration under ``timing``."""
    scenario = ride.scenario
    return {
        **measure(ride),
        "outcome": ride.outcome.value,
        "scenario": scenario.name,
        "seed": ride.seed,
        "mode": scenario.mode.value,
        "robot": ride.robot.name,
        "people": len(ride.people_radius),
        "people_from": "simulation" if scenario.tracker["use"] == "given" else "sensors",
        "planner": scenario.local_planner["use"],
        "method": scenario.global_planner["use"],
        "rider": scenario.rider["use"],
        "simulated_time": float(ride.time[-1]),
        "stops": [
            {
                "time": s.time,
                "duration": s.duration,
                "reason": s.reason.value,
                "detail": s.detail,
            }
            for s in ride.stops
        ],
        "replans": [{"time": r.time, "why": r.why.value} for r in ride.replans],
        "versions": versions(),
        "timing": {"wall_time": wall_time, **timing(ride)},
    }


def _onto_map(base: Scenario, asked: Asked) -> dict[str, Any]:
    """The changes that carry a scenario over to another map: nothing that lies somewhere stays."""
    if asked.start is None or asked.goal is None:
        raise ConfigError("a map of your own needs --start x,y and --goal x,y", key="--map")
    people = base.people.model_dump(mode="json", exclude={"ways", "groups", "flows"})
    if people["count"] is None:
        people["count"] = people_of(base.people) or PEOPLE_ON_A_MAP
    return {
        "map": str(Path(asked.map or "").absolute()),
        "floor": None,
        "plan": None,
        "onto": None,
        "rider_goal": None,
        "rider_route": None,
        "companion": None,
        "prefer": None,
        "stroke": None,
        "avoid": None,
        "obstacles": None,
        "doors": None,
        "filters": None,
        "crowding": None,
        "rider": {"use": base.rider["use"]},
        "people": people,
        "time_limit": 600.0,
    }


def _check_installed(group: str, name: str, option: str) -> None:
    """Refuse a part that there is not, by the option that asks for it."""
    known = names(group)
    if name not in known:
        what = group.replace("_", " ").removesuffix("s")
        raise ConfigError(f"no {what} is called {name!r}{nearest(name, known)}", key=option)


def _robot(name_or_file: str) -> str:
    file = Path(name_or_file)
    return str(file.absolute()) if file.suffix in {".yaml", ".yml"} else name_or_file


def _check_outputs(outputs: Outputs) -> None:
    """Refuse what cannot be written before riding for it."""
    if outputs.plot is not None or outputs.animate is not None:
        from cohelm.pictures import check_animation, check_picture  # noqa: PLC0415 # lazy

        if outputs.plot is not None:
            check_picture(outputs.plot)
        if outputs.animate is not None:
            check_animation(outputs.animate)
    if outputs.record is not None:
        check_record(outputs.record)
    if outputs.out is not None:
        try:
            outputs.out.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=outputs.out):
                pass
        except OSError as cause:
            raise ConfigError(
                f"{outputs.out} is no folder to write to ({cause.strerror})", key="--out"
            ) from None


def _write_pictures(ride: Ride, report: Mapping[str, Any], title: str, outputs: Outputs) -> None:
    files = [outputs.plot, None if outputs.out is None else outputs.out / "ride.png"]
    if outputs.animate is None and not any(files):
        return
    from cohelm.pictures import animate_ride, draw_ride  # noqa: PLC0415 # lazy

    if not outputs.quiet and ERRORS.is_terminal:
        ERRORS.print("drawing …")
    headline = _headline(ride, report, title)
    for file in files:
        if file is not None:
            draw_ride(ride, file, title=headline)
    if outputs.animate is not None:
        animate_ride(ride, outputs.animate, title=title)


def _write_folder(ride: Ride, report: Mapping[str, Any], folder: Path) -> None:
    try:
        _write_report(ride, report, folder)
    except OSError as cause:
        raise ConfigError(f"{folder} cannot be written ({cause.strerror})", key="--out") from None


def _write_report(ride: Ride, report: Mapping[str, Any], folder: Path) -> None:
    (folder / "ride.json").write_text(as_json(report, indent=2) + "\n", encoding="utf-8")
    columns = {
        "time": ride.time,
        "x": ride.pose[:, 0],
        "y": ride.pose[:, 1],
        "heading": ride.pose[:, 2],
        "speed": ride.twist[:, 0],
        "turn_rate": ride.twist[:, 2],
        "command_speed": ride.command[:, 0],
        "command_turn_rate": ride.command[:, 2],
        "eta": ride.eta,
        "nearest_person": ride.nearest,
        "wall": ride.gap_wall,
    }
    with (folder / "track.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in np.column_stack(list(columns.values())):
            writer.writerow([f"{number:.6g}" if np.isfinite(number) else "" for number in row])


def _say(ride: Ride, report: Mapping[str, Any], title: str, outputs: Outputs) -> None:
    if outputs.json:
        write_json(report)
        return
    if not outputs.quiet:
        OUTPUT.print(metrics_table(title, measure(ride), report["timing"]))
        for stop in ride.stops:
            what = f"{stop.reason.sentence} ({stop.reason.value})"
            OUTPUT.print(f"at {stop.time:.1f} s, for {stop.duration:.2f} s: {what}", markup=False)
        for replan in ride.replans:
            OUTPUT.print(f"at {replan.time:.1f} s: a new path ({replan.why.value})", markup=False)
        for file in (outputs.plot, outputs.animate, outputs.record, outputs.out):
            if file is not None:
                OUTPUT.print(f"written: {file}", markup=False)
    sys.stdout.write(f"outcome: {ride.outcome.value}\n")


def _headline(ride: Ride, report: Mapping[str, Any], title: str) -> str:
    """What a picture says of its ride: with the numbers that the table has."""
    taken = report["time"] if ride.outcome is Outcome.REACHED else ride.time[-1]
    nearest = report["min_distance"]
    gap = f", nearest person {nearest:.2f} m" if math.isfinite(nearest) else ""
    return f"{title}: {ride.outcome.value} after {taken:.1f} s{gap}"
