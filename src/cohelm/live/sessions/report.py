"""Exports of a session: one HTML file without external resources, and a CSV table."""

from __future__ import annotations

import base64
import csv
import io
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from cohelm.evaluation.metrics.measures import RIDE_MEASURES, measure_info
from cohelm.evaluation.report.html import Table, render
from cohelm.live.messages import Limits
from cohelm.live.sessions.records import RideSummary, SessionInfo, SessionSummary


class _Column(NamedTuple):
    """Column of the CSV table."""

    name: str
    cell: Callable[[SessionInfo, RideSummary], object]


class _RideSection(NamedTuple):
    """Content of one ride in the HTML report."""

    id: str
    title: str
    facts: tuple[tuple[str, str], ...]
    image: str
    """PNG map as base64; empty: none."""
    message: str
    measures: Table | None
    stops: Table | None


def session_html(summary: SessionSummary, maps: Mapping[str, bytes]) -> str:
    """Return the session as one printable page, light or dark as the reader's device.

    Args:
        summary: Session with its rides.
        maps: PNG maps by ride id, as far as they exist.
    """
    session = summary.session
    where = "in simulation" if session.simulation else "on the chair"
    started = session.started[:16].replace("T", " at ")
    rides = Table(
        columns=("ride", "destination", "outcome", "duration, s", "length, m", "rating"),
        rows=[
            (
                str(number),
                _destination(ride),
                _outcome(ride),
                f"{ride.duration:.0f}",
                f"{ride.length:.1f}",
                _rating(ride),
            )
            for number, ride in enumerate(summary.rides, 1)
        ],
        caption="Rides",
    )
    return render(
        "session.html",
        package="cohelm.live.sessions",
        title=f"Session of {session.started[:10]}",
        summary=f"{session.scene} {where}, {session.robot}; started {started} UTC.",
        rides=rides,
        details=[
            _section(number, ride, maps.get(ride.id))
            for number, ride in enumerate(summary.rides, 1)
        ],
    )


def session_csv(summary: SessionSummary) -> str:
    """Return one row for each ride: facts, limits and all measures, in SI units."""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow([column.name for column in _COLUMNS])
    for ride in summary.rides:
        cells = [column.cell(summary.session, ride) for column in _COLUMNS]
        writer.writerow([_no_formula(cell) for cell in cells])
    return out.getvalue()


def _section(number: int, ride: RideSummary, image: bytes | None) -> _RideSection:
    outcome = f"{_outcome(ride)} after {ride.duration:.0f} s, {ride.length:.1f} m"
    measures = [
        (info.heading, info.text(ride.measures[name]))
        for name, info in ((name, measure_info(name)) for name in RIDE_MEASURES)
        if name in ride.measures
    ]
    stops = [(f"{stop.time:.0f}", f"{stop.duration:.1f}", stop.text) for stop in ride.stops]
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
        message=ride.error or ("" if measures else "The measures are not ready yet."),
        measures=Table(("measure", "value"), measures, "Measures") if measures else None,
        stops=Table(("time, s", "duration, s", "reason"), stops, "Stops") if stops else None,
    )


def _destination(ride: RideSummary) -> str:
    return ride.destination or "no destination"


def _outcome(ride: RideSummary) -> str:
    """Outcome in words; a ride without a destination cannot be cancelled."""
    no_goal = ride.outcome == "cancelled" and not ride.destination
    return "ended" if no_goal else ride.outcome


def _rating(ride: RideSummary) -> str:
    return "not rated" if ride.rating is None else f"{ride.rating} of 5"


def _durations(seconds: Mapping[Any, float]) -> str:
    """``shared 41 s, assisted 3 s``, the longest first."""
    longest = sorted(seconds.items(), key=lambda each: -each[1])
    return ", ".join(f"{name} {each:.0f} s" for name, each in longest if each >= 0.5)


def _limits(time: float, limits: Limits) -> str:
    text = (
        f"{limits.max_speed:g} m/s, {limits.max_acceleration:g} m/s², "
        f"{limits.min_distance:g} m from people"
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
