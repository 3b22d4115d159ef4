"""``cohelm run``: simulate a ride, and write what happened."""

from __future__ import annotations

import csv
import math
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from cohelm.cli.progress import RideProgress
from cohelm.cli.report import (
    ERRORS,
    OUTPUT,
    as_json,
    plain_table,
    print_line,
    versions,
    write_json,
)
from cohelm.cli.requests import RunRequest
from cohelm.cli.scenario_request import check_record, named_after_options, scenario_of
from cohelm.errors import ConfigError
from cohelm.evaluation import Outcome, Ride, measure, timing
from cohelm.evaluation import run as run_scenario
from cohelm.evaluation.metrics.measures import measure_info
from cohelm.evaluation.sweeps.ride_task import speed_where
from cohelm.scenarios import Scenario

SUMMARY = ("time", "min_distance", "stop_rate", "jerk_rms", "rider_effort")
"""Measures that a ride ends with, besides its outcome; ``--all`` prints every one."""
MIN_STOP = 0.1
"""Shorter stops are not listed, s."""


def run(request: RunRequest) -> int:
    """Simulate; returns 0 where the goal was reached, else 1.

    Raises:
        CohelmError: if an option, a file or the scenario is at fault.
    """
    _check_outputs(request)
    scenario = scenario_of(request)
    seed = scenario.seed if request.seed is None else request.seed
    on_map = "" if request.map is None else f" on {Path(request.map).stem}"
    title = f"{scenario.name}{on_map}, seed {seed}"
    began = time.monotonic()
    with (
        named_after_options(request),
        RideProgress(title, scenario.time_limit, shown=not request.quiet) as progress,
    ):
        ride = _simulated(scenario, seed, progress, request.record)
    report = summary(ride, time.monotonic() - began)
    _draw(ride, report, title, request)
    if request.out is not None:
        try:
            _write_folder(ride, report, request.out)
        except OSError as cause:
            problem = f"{request.out} cannot be written ({cause.strerror})"
            raise ConfigError(problem, key="--out") from None
    _print(ride, report, title, request)
    return 0 if ride.outcome is Outcome.REACHED else 1


def summary(ride: Ride, wall_time: float) -> dict[str, Any]:
    """Content of ``--json``: measures by name, outcome, stops, and durations under ``timing``."""
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
                "time": stop.time,
                "duration": stop.duration,
                "reason": stop.reason.value,
                "detail": stop.detail,
            }
            for stop in ride.stops
        ],
        "replans": [{"time": replan.time, "why": replan.why.value} for replan in ride.replans],
        "versions": versions(),
        "timing": {"wall_time": wall_time, **timing(ride)},
    }


def _simulated(scenario: Scenario, seed: int, progress: RideProgress, record: Path | None) -> Ride:
    if record is None:
        return run_scenario(scenario, seed, progress)
    from cohelm.evaluation.episode.recorded import run_recorded

    return run_recorded(scenario, seed, record, progress)


def _check_outputs(request: RunRequest) -> None:
    """Refuse outputs that cannot be written, before the ride."""
    if request.plot is not None or request.animate is not None:
        from cohelm.plotting import check_animation, check_picture

        if request.plot is not None:
            check_picture(request.plot)
        if request.animate is not None:
            check_animation(request.animate)
    if request.view is not None:
        from cohelm.platforms.twin import check_film

        if request.animate is None:
            raise ConfigError("needs --animate FILE.gif or FILE.mp4", key="--view")
        check_film(request.animate, request.view)
    if request.record is not None:
        check_record(request.record)
    if request.out is not None:
        make_folder(request.out)


def make_folder(folder: Path, key: str = "--out") -> None:
    """Make the folder of an option if its parent exists, and check that it can be written to.

    Raises:
        ConfigError: naming the folder that is missing, or cannot be written to.
    """
    parent = folder.absolute().parent
    if not parent.is_dir():
        raise ConfigError(f"no folder {parent}", key=key)
    try:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as cause:
        problem = f"{folder} is not a folder to write to ({cause.strerror})"
        raise ConfigError(problem, key=key) from None


def _draw(ride: Ride, report: Mapping[str, Any], title: str, request: RunRequest) -> None:
    files = [request.plot, None if request.out is None else request.out / "ride.png"]
    if request.animate is None and not any(files):
        return
    from cohelm.plotting import AnimationStyle, animate_ride, draw_ride

    if not request.quiet and ERRORS.is_terminal:
        ERRORS.print("drawing …")
    headline = _headline(ride, report, title)
    for file in files:
        if file is not None:
            draw_ride(ride, file, title=headline)
    if request.animate is not None and request.view is not None:
        from cohelm.platforms.twin import film_ride

        film_ride(ride, request.animate, request.view, speed_up=request.speed_up)
    elif request.animate is not None:
        style = AnimationStyle(speed_up=request.speed_up)
        animate_ride(ride, request.animate, title, style)


def _write_folder(ride: Ride, report: Mapping[str, Any], folder: Path) -> None:
    """Write ride.json, track.csv and socnav3.json."""
    from cohelm.evaluation.report.socnav3 import trajectory

    (folder / "socnav3.json").write_text(as_json(trajectory(ride)) + "\n", encoding="utf-8")
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


def _print(ride: Ride, report: Mapping[str, Any], title: str, request: RunRequest) -> None:
    if request.json:
        write_json(report)
        return
    if not request.quiet:
        OUTPUT.print(Text(title, style="bold"))
        if request.all:
            OUTPUT.print(_measures(measure(ride), report["timing"]))
            for replan in ride.replans:
                print_line(f"at {replan.time:.1f} s: new route ({replan.why.value})")
        stops = [stop for stop in ride.stops if stop.duration >= MIN_STOP]
        for stop in stops:
            reason = f"{stop.reason.sentence} ({stop.reason.value})"
            print_line(f"at {stop.time:.1f} s, for {stop.duration:.1f} s: {reason}")
        for line in _contacts(ride):
            print_line(line)
        for line in _map_notes(ride):
            print_line(line)
        for file in (request.plot, request.animate, request.record, request.out):
            if file is not None:
                print_line(f"written: {file}")
        OUTPUT.print(_summary(measure(ride)))
    sys.stdout.write(f"outcome: {ride.outcome.value}\n")


def _contacts(ride: Ride) -> list[str]:
    """Sentences on what the chair touched or fell from, and on people who touched it."""
    before = np.vstack([np.zeros_like(ride.hit_standing[:1]), ride.hit_standing[:-1]])
    begun, _ = np.nonzero(ride.hit_standing & ~before)
    lines = [
        f"at {time:.1f} s: a person touched the chair while it stood" for time in ride.time[begun]
    ]
    if ride.outcome is Outcome.FELL:
        x, y = ride.pose[-1, :2]
        lines.append(f"at {ride.time[-1]:.1f} s: a wheel fell over an edge at ({x:.2f}, {y:.2f})")
    if ride.outcome is Outcome.COLLISION:
        last = np.arange(len(ride.time)) == len(ride.time) - 1
        hits = {"a person": ride.hit_moving[-1].any(), "a wall or an obstacle": ride.hit_wall[-1]}
        touched = " and ".join(what for what, hit in hits.items() if hit)
        x, y = ride.pose[-1, :2]
        lines.append(
            f"at {ride.time[-1]:.1f} s: the chair touched {touched} "
            f"at {speed_where(ride, last):.2f} m/s, at ({x:.2f}, {y:.2f})"
        )
    return lines


def _map_notes(ride: Ride) -> list[str]:
    """Sentences on persistent contradictions between map and sweeps."""
    from cohelm.cli.map_changes import change_notes

    health = ride.ticks[-1].memory.health if ride.ticks else None
    return [] if health is None else change_notes(health.changes)


def _summary(measures: Mapping[str, float]) -> Table:
    """The few figures that a ride ends with."""
    table = Table(show_header=False, show_edge=False, box=None, pad_edge=False)
    table.add_column("", style="dim")
    table.add_column("", justify="right")
    table.add_column("", style="dim")
    for name in SUMMARY:
        table.add_row(*_row(name, measures[name]))
    return table


def _measures(measures: Mapping[str, float], times: Mapping[str, Any]) -> Table:
    """Every measure that this ride has, and computing times."""
    table = plain_table("measure", "value", "unit", "name in --json")
    for name, number in measures.items():
        if math.isfinite(number):
            table.add_row(*_row(name, number), name)
    table.add_section()
    for stage in ("control", "tick"):
        if stage in times:
            cells = " / ".join(f"{1e3 * times[stage][k]:.2f}" for k in ("median", "p99", "max"))
            table.add_row(f"{stage}: median / 99 % / maximum", cells, "ms", f"timing.{stage}")
    if "tick" in times:
        first = f"{1e3 * times['tick']['first']:.2f}"
        table.add_row("first tick (includes compilation)", first, "ms", "timing.tick.first")
    return table


def _row(name: str, number: float) -> tuple[str, str, str]:
    """Label, value and unit of a measure."""
    info = measure_info(name)
    count = (
        info.unit == "" and info.digits == 1 and float(number).is_integer()
    )  # means have decimals
    return info.label, f"{number:.0f}" if count else info.text(number), info.unit


def _headline(ride: Ride, report: Mapping[str, Any], title: str) -> str:
    """Title of a picture: outcome, time and nearest person."""
    taken = report["time"] if ride.outcome is Outcome.REACHED else ride.time[-1]
    nearest = report["min_distance"]
    gap = f", nearest person {nearest:.2f} m" if math.isfinite(nearest) else ""
    return f"{title}: {ride.outcome.value} after {taken:.1f} s{gap}"
