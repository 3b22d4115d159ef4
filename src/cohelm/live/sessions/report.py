"""Exports of a session: one HTML file without external resources, and a CSV table."""

from __future__ import annotations

import base64
import csv
import io
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from cohelm.evaluation.metrics.measures import RIDE_MEASURES, measure_info
from cohelm.evaluation.report.html import Table, render
from cohelm.live.messages import Limits
from cohelm.live.sessions.records import RideStop, RideSummary, SessionInfo, SessionSummary
from cohelm.live.sessions.timeline import Timeline
from cohelm.reasons import Reason

BREACH_TOLERANCE = 0.005
"""Distance by which a person may be closer than the target before a report says so, m."""
SPEED_TOLERANCE = 0.05
"""Speed above the limit before a report says so, m/s: the error of a measured speed; assumed."""


class _Column(NamedTuple):
    """Column of the CSV table."""

    name: str
    cell: Callable[[SessionInfo, RideSummary], object]


class _Strip(NamedTuple):
    """Plot of a ride over its time, in a box of 1000 × 110."""

    duration: str
    fastest: str
    speed: str
    """Points of a polyline."""
    share: str
    reasons: tuple[tuple[float, float], ...]
    """Left side and width of each reason."""


class _RideSection(NamedTuple):
    """Content of one ride in the HTML report."""

    id: str
    title: str
    facts: tuple[tuple[str, str], ...]
    image: str
    """PNG map as base64; empty: none."""
    strip: _Strip | None
    """Speed and share over time; None: no timeline is stored."""
    message: str
    measures: Table | None
    stops: Table | None


def session_html(
    summary: SessionSummary,
    maps: Mapping[str, bytes],
    timelines: Mapping[str, Timeline] = MappingProxyType({}),
    *,
    rider: str = "",
) -> str:
    """Return the session as one page with folded details, light or dark as the reader's device.

    Args:
        summary: Session with its rides.
        maps: PNG maps by ride id, as far as they exist.
        timelines: Timelines by ride id, as far as they exist.
        rider: Name of the rider; empty: nobody was chosen.
    """
    session = summary.session
    where = "in simulation" if session.simulation else "on the chair"
    started = session.started[:16].replace("T", " at ")
    return render(
        "session.html",
        package="cohelm.live.sessions",
        title=f"Session of {session.started[:10]}",
        rider=rider or "nobody was chosen",
        summary=f"{session.scene} {where}, {session.robot}; started {started} UTC.",
        breaches=[
            f"Ride {number}: {text}"
            for number, ride in enumerate(summary.rides, 1)
            for text in breaches(ride, timelines.get(ride.id))
        ],
        checked=bool(timelines) or any("min_distance" in ride.measures for ride in summary.rides),
        rides=_rides_table(summary.rides),
        details=[
            _section(number, ride, maps.get(ride.id), timelines.get(ride.id))
            for number, ride in enumerate(summary.rides, 1)
        ],
    )


def breach_of_distance(ride: RideSummary) -> tuple[float, float] | None:
    """Return (nearest person, target) if somebody came closer than the target, m; else None."""
    nearest = ride.measures.get("min_distance", ride.nearest)
    if nearest is None or not ride.limits:
        return None
    target = max(each.limits.min_distance for each in ride.limits)
    return (nearest, target) if nearest < target - BREACH_TOLERANCE else None


def breaches(ride: RideSummary, timeline: Timeline | None) -> list[str]:
    """Return a sentence for each limit that a ride did not keep.

    The acceleration has none: its limit does not hold for braking, which the measure contains.
    """
    found = []
    near = breach_of_distance(ride)
    if near is not None:
        found.append(f"a person was at {near[0]:.2f} m, closer than the target of {near[1]:g} m.")
    if timeline is not None and ride.limits:
        limit = max(each.limits.max_speed for each in ride.limits)
        fastest = max((abs(speed) for speed in timeline.speed), default=0.0)
        if fastest > limit + SPEED_TOLERANCE:
            found.append(f"the chair drove at {fastest:.2f} m/s, above the limit of {limit:g} m/s.")
    return found


def session_csv(summary: SessionSummary) -> str:
    """Return one row for each ride: facts, limits and all measures, in SI units."""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow([column.name for column in _COLUMNS])
    for ride in summary.rides:
        cells = [column.cell(summary.session, ride) for column in _COLUMNS]
        writer.writerow([_no_formula(cell) for cell in cells])
    return out.getvalue()


def _rides_table(rides: Sequence[RideSummary]) -> Table:
    """One row for each ride."""
    return Table(
        columns=(
            "ride",
            "destination",
            "outcome",
            "duration, s",
            "length, m",
            "stops",
            "nearest person, m",
            "rating",
        ),
        rows=[
            (
                str(number),
                _destination(ride),
                _outcome(ride),
                f"{ride.duration:.0f}",
                f"{ride.length:.1f}",
                str(len(ride.stops)),
                _nearest(ride),
                _rating(ride),
            )
            for number, ride in enumerate(rides, 1)
        ],
        caption="Rides",
    )


def _section(
    number: int, ride: RideSummary, image: bytes | None, timeline: Timeline | None
) -> _RideSection:
    outcome = f"{_outcome(ride)} after {ride.duration:.0f} s, {ride.length:.1f} m"
    measures = [
        (info.heading, info.text(ride.measures[name]))
        for name, info in ((name, measure_info(name)) for name in RIDE_MEASURES)
        if name in ride.measures
    ]
    stops = [(f"{stop.time:.0f}", f"{stop.duration:.1f}", _cause(stop)) for stop in ride.stops]
    return _RideSection(
        id=ride.id,
        title=f"Ride {number}: {_destination(ride)}",
        facts=(
            ("Outcome", outcome),
            ("Rating", _rating(ride)),
            ("Modes", _durations(ride.modes) or "none"),
            ("Devices", _durations(ride.devices) or "none"),
            ("Limits", "; ".join(_limits(each.time, each.limits) for each in ride.limits)),
        ),
        image="" if image is None else base64.b64encode(image).decode(),
        strip=None if timeline is None else _strip(timeline),
        message=ride.error or ("" if measures else "The measures are not ready yet."),
        measures=Table(("measure", "value"), measures, "Measures") if measures else None,
        stops=Table(("time, s", "duration, s", "reason"), stops, "Stops") if stops else None,
    )


def _strip(timeline: Timeline) -> _Strip:
    duration = max((len(timeline.pose) - 1) * timeline.period, timeline.period)
    fastest = max(0.5, *timeline.speed)

    def line(values: Sequence[float], most: float) -> str:
        xs = (1000.0 * k / max(len(values) - 1, 1) for k in range(len(values)))
        return " ".join(
            f"{x:.1f},{105.0 - 100.0 * max(value, 0.0) / most:.1f}"
            for x, value in zip(xs, values, strict=True)
        )

    return _Strip(
        duration=f"{duration:.0f}",
        fastest=f"{fastest:.1f}",
        speed=line(timeline.speed, fastest),
        share=line(timeline.eta, 1.0),
        reasons=tuple(
            (round(1000.0 * each.time / duration, 1), round(1000.0 * each.duration / duration, 1))
            for each in timeline.reasons
        ),
    )


def _destination(ride: RideSummary) -> str:
    return ride.destination or "no destination"


def _outcome(ride: RideSummary) -> str:
    """Outcome in words; a ride without a destination cannot be cancelled."""
    no_goal = ride.outcome == "cancelled" and not ride.destination
    return "ended" if no_goal else ride.outcome


def _rating(ride: RideSummary) -> str:
    return "not rated" if ride.rating is None else f"{ride.rating} of 5"


def _nearest(ride: RideSummary) -> str:
    """Distance of the nearest person, and the target if somebody came closer."""
    nearest = ride.measures.get("min_distance", ride.nearest)
    if nearest is None:
        return "–"
    near = breach_of_distance(ride)
    return f"{nearest:.2f}" + (f", closer than the target of {near[1]:g}" if near else "")


def _cause(stop: RideStop) -> str:
    """Reason of a stop for the reader of the report; an unknown code keeps its stored text."""
    known = {each.value: each.report for each in Reason}
    return known.get(stop.code, stop.text)


def _durations(seconds: Mapping[Any, float]) -> str:
    """``shared 41 s, assisted 3 s``, the longest first."""
    longest = sorted(seconds.items(), key=lambda each: -each[1])
    return ", ".join(f"{name} {each:.0f} s" for name, each in longest if each >= 0.5)


def _limits(time: float, limits: Limits) -> str:
    text = (
        f"{limits.max_speed:g} m/s, {limits.max_acceleration:g} m/s², "
        f"target {limits.min_distance:g} m from people"
    )
    return text if time <= 0.0 else f"from {time:.0f} s: {text}"


def _no_formula(cell: object) -> object:
    """Mark text that a spreadsheet would take for a formula as text."""
    risky = isinstance(cell, str) and cell[:1] in {"=", "+", "-", "@", "\t", "\r"}
    return f"'{cell}" if risky else cell


def _limit_column(name: str) -> _Column:
    """Column of one of the limits at the end of the ride."""
    return _Column(
        f"limit_{name}",
        lambda _, ride: getattr(ride.limits[-1].limits, name) if ride.limits else "",
    )


def _measure_column(name: str) -> _Column:
    return _Column(
        name,
        lambda _, ride: f"{ride.measures[name]:.6g}" if name in ride.measures else "",
    )


_COLUMNS = (
    _Column("session", lambda session, _: session.id),
    _Column("ride", lambda _, ride: ride.id),
    _Column("started", lambda _, ride: ride.started),
    _Column("rider", lambda session, _: session.rider),
    _Column("scene", lambda session, _: session.scene),
    _Column("robot", lambda session, _: session.robot),
    _Column("seed", lambda _, ride: ride.seed),
    _Column("destination", lambda _, ride: ride.destination),
    _Column("outcome", lambda _, ride: ride.outcome),
    _Column("duration", lambda _, ride: f"{ride.duration:.2f}"),
    _Column("length", lambda _, ride: f"{ride.length:.3f}"),
    _Column("rating", lambda _, ride: "" if ride.rating is None else ride.rating),
    _Column("wishes", lambda _, ride: ride.wishes),
    _Column("modes", lambda _, ride: _durations(ride.modes)),
    _Column("devices", lambda _, ride: _durations(ride.devices)),
    *map(_limit_column, Limits.model_fields),
    _Column("stops", lambda _, ride: len(ride.stops)),
    *map(_measure_column, RIDE_MEASURES),
    _Column("error", lambda _, ride: ride.error),
)
"""Columns of the CSV table."""
