"""A session on paper: one HTML file that needs nothing else, and a table for a spreadsheet."""

from __future__ import annotations

import base64
import csv
import io
from collections.abc import Mapping
from html import escape
from typing import Any

from cohelm.driving.messages import Limits
from cohelm.driving.records import RideRecord, SessionSummary
from cohelm.evaluation.metrics.table import MEASURES

OUTCOMES = {"arrived": "arrived", "left": "left on the way", "collision": "touched something"}
WORDS: dict[str, tuple[str, str]] = {
    "time": ("time to the destination", "s"),
    "path_length": ("way driven", "m"),
    "encounters": ("people met within 2 m", ""),
    "min_distance": ("least distance from a person", "m"),
    "mean_distance": ("mean distance from the nearest person", "m"),
    "collisions_person": ("people touched by the moving chair", ""),
    "collisions_wall": ("times that a wall was touched", ""),
    "standing_contacts": ("people who touched the standing chair", ""),
    "wall_distance": ("least distance from a wall", "m"),
    "time_to_collision": ("least time to a contact, both going on", "s"),
    "proxemics_intimate": ("share of time with somebody within 0.45 m", "%"),
    "proxemics_personal": ("… within 0.45 to 1.2 m", "%"),
    "proxemics_social": ("… within 1.2 to 3.6 m", "%"),
    "social_space_intrusion_share": ("share of time in somebody's space", "%"),
    "heading_change": ("turning, all together", "rad"),
    "acceleration_max": ("greatest acceleration or braking", "m/s²"),
    "jerk_rms": ("jerk, root mean square", "m/s³"),
    "stalled_time": ("time standing on the way", "s"),
    "path_error": ("mean distance from the first route", "m"),
    "preference_distance": ("greatest distance from the wishes", "m"),
    "spl": ("shortness of the way, 1 is the shortest", ""),
    "authority": ("the rider's share in steering", "%"),
    "agreement": ("agreement of what was asked and done, −1 to 1", ""),
    "intervention_share": ("share of time in which the chair did otherwise than asked", "%"),
    "fight_rate": ("share of time in which the chair turned the other way", "%"),
    "rider_effort": ("movement of the stick, in full deflections", ""),
    "rider_reversals": ("changes of the stick's direction", "1/min"),
}
"""Measures that the page shows, in plain words and with units; the table has them all."""

_STYLE = """
:root{color-scheme:light dark;--ink:#1b2530;--soft:#55606c;--line:#d5dae0;--paper:#fff}
@media (prefers-color-scheme:dark){:root{--ink:#e8ecf1;--soft:#a9b3bf;--line:#3a444f;
--paper:#151b21}}
@media print{:root{--ink:#000;--soft:#333;--line:#999;--paper:#fff}section{break-inside:avoid-page}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);
max-width:52rem;margin:2rem auto;padding:0 1rem}
h1,h2{line-height:1.2}p.soft,caption,small{color:var(--soft)}
table{border-collapse:collapse;width:100%;margin:1rem 0}caption{text-align:left}
th,td{text-align:left;padding:.3rem .6rem;border-bottom:1px solid var(--line);vertical-align:top;
overflow-wrap:anywhere}
th.number,td.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
img{max-width:100%;height:auto;border:1px solid var(--line);background:#fff}
section{margin-top:2.5rem}
"""


_FACTS = (
    "session", "ride", "began", "scene", "robot", "seed", "destination", "outcome", "seconds",
    "metres", "rating", "wishes", "modes", "devices",
)  # fmt: skip
"""The first columns of the table."""
_NUMBERS, _RIGHT = frozenset({"time", "way", "value", "at", "for"}), ' class="number"'
"""Columns of the page that are numbers."""


def session_html(summary: SessionSummary, maps: Mapping[str, bytes]) -> str:
    """The session as one page: light or dark as the reader has it, and printable.

    Args:
        summary: of the session.
        maps: PNGs of the rides by their ids; those that there are.
    """
    facts = summary.facts
    where = "in simulation" if facts.simulation else "on the chair"
    title = f"Session of {facts.began[:10]}"
    rows = "".join(
        f"<tr><td>{n}</td><td>{escape(_destination(r))}</td><td>{_outcome(r)}</td>"
        f'<td class="number">{r.time:.0f} s</td><td class="number">{r.length:.1f} m</td>'
        f"<td>{_rating(r)}</td></tr>"
        for n, r in enumerate(summary.rides, 1)
    )
    head = ("ride", "destination", "outcome", "time", "way", "rating")
    rides = "".join(_ride(n, ride, maps.get(ride.id)) for n, ride in enumerate(summary.rides, 1))
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body><main>"
        f"<h1>{escape(title)}</h1>"
        f'<p class="soft">{escape(facts.scene)} {where}, {escape(facts.robot)}; began '
        f"{escape(facts.began[:16].replace('T', ' at '))} UTC.</p>"
        f"{_table('The rides', head, rows)}{rides}</main></body></html>\n"
    )


def session_csv(summary: SessionSummary) -> str:
    """A row for each ride: what happened, what was in force, and every measure; SI units."""
    out = io.StringIO()
    writer = csv.writer(out)
    names = tuple(MEASURES)
    limits = tuple(Limits.model_fields)
    writer.writerow([*_FACTS, *(f"limit_{name}" for name in limits), "stops", *names, "trouble"])
    for ride in summary.rides:
        last = ride.limits[-1].limits.model_dump() if ride.limits else {}
        cells = [
            summary.facts.id, ride.id, ride.began, summary.facts.scene, summary.facts.robot,
            ride.seed, ride.destination, ride.outcome, f"{ride.time:.2f}", f"{ride.length:.3f}",
            "" if ride.rating is None else ride.rating, ride.wishes,
            _shares(ride.modes), _shares(ride.devices),
            *(last.get(name, "") for name in limits),
            len(ride.stops), *(_measure(ride, name) for name in names), ride.trouble,
        ]  # fmt: skip
        writer.writerow([_harmless(cell) for cell in cells])
    return out.getvalue()


def _ride(number: int, ride: RideRecord, picture: bytes | None) -> str:
    title = f"Ride {number}: {_destination(ride)}"
    facts = "".join(
        f'<tr><th scope="row">{name}</th><td>{escape(text)}</td></tr>'
        for name, text in (
            ("Outcome", f"{_outcome(ride)} after {ride.time:.0f} s, {ride.length:.1f} m"),
            ("Rating", _rating(ride)),
            ("Who steered", _shares(ride.modes) or "nobody"),
            ("By", _shares(ride.devices) or "no device"),
            ("Limits", "; ".join(_limits(each.time, each.limits) for each in ride.limits)),
        )
    )
    image = ""
    if picture is not None:
        data = base64.b64encode(picture).decode()
        image = (
            f'<img alt="Map of ride {number}: the track, blue where the chair steered and orange '
            f'where the rider did" src="data:image/png;base64,{data}">'
            "<p><small>Track: blue where the chair steered, orange where the rider did. Green: "
            "start; purple: destination; red: touched.</small></p>"
        )
    measures = "".join(
        f"<tr><td>{escape(words)}</td>"
        f'<td class="number">{_said(ride.measures[name], unit)}</td></tr>'
        for name, (words, unit) in WORDS.items()
        if name in ride.measures
    )
    stops = "".join(
        f'<tr><td class="number">{s.time:.0f} s</td><td class="number">{s.duration:.1f} s</td>'
        f"<td>{escape(s.text)}</td></tr>"
        for s in ride.stops
    )
    trouble = ride.trouble or ("" if measures else "The measures are still being taken.")
    return (
        f"<section><h2>{escape(title)}</h2><table><tbody>{facts}</tbody></table>{image}"
        + (f"<p>{escape(trouble)}</p>" if trouble else "")
        + (_table("How it went", ("measure", "value"), measures) if measures else "")
        + (_table("Stops and why", ("at", "for", "reason"), stops) if stops else "")
        + "</section>"
    )


def _table(caption: str, head: tuple[str, ...], rows: str) -> str:
    cells = "".join(
        f'<th scope="col"{_RIGHT if each in _NUMBERS else ""}>{each}</th>' for each in head
    )
    return (
        f"<table><caption>{caption}</caption><thead><tr>{cells}</tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def _destination(ride: RideRecord) -> str:
    return ride.destination or "no destination"


def _outcome(ride: RideRecord) -> str:
    """Where it went nowhere, nothing was left: it ended."""
    nowhere = ride.outcome == "left" and not ride.destination
    return "ended" if nowhere else OUTCOMES[ride.outcome]


def _rating(ride: RideRecord) -> str:
    return "not rated" if ride.rating is None else f"{ride.rating} of 5"


def _shares(seconds: Mapping[Any, float]) -> str:
    """``shared 41 s, assisted 3 s``, the longest first."""
    longest = sorted(seconds.items(), key=lambda each: -each[1])
    return ", ".join(f"{name} {each:.0f} s" for name, each in longest if each >= 0.5)


def _limits(time: float, limits: Limits) -> str:
    text = (
        f"{limits.max_speed:g} m/s, {limits.max_acceleration:g} m/s², "
        f"{limits.min_distance:g} m from people"
    )
    return text if time <= 0.0 else f"from {time:.0f} s on {text}"


def _said(number: float, unit: str) -> str:
    if unit == "%":
        return f"{100.0 * number:.0f} %"
    return f"{number:.3g} {unit}".strip()


def _measure(ride: RideRecord, name: str) -> str:
    return f"{ride.measures[name]:.6g}" if name in ride.measures else ""


def _harmless(cell: object) -> object:
    """Text that a spreadsheet would take for a formula, as text."""
    risky = isinstance(cell, str) and cell[:1] in {"=", "+", "-", "@", "\t", "\r"}
    return f"'{cell}" if risky else cell
