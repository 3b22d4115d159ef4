"""Report on the accessibility of a building for one chair, as HTML and for JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

from markupsafe import Markup

from cohelm.buildings import AccessReport, BuildingStorey, RoomAccess
from cohelm.errors import ConfigError
from cohelm.evaluation.report.html import Content, Table, TableCell, render
from cohelm.plotting import AccessMarks, storey_svg

_LIMITS = (
    "Computed from the building's model or map, not measured on site. What the model lacks, as "
    "furniture, kerbs, slopes or locked doors, is unknown to this report.",
    "A room counts as reached if the route planner finds a path for the chair's footprint "
    "to a point in it. A person may drive manoeuvres that the planner does not find.",
    "A map is up to two cells narrower than the building, never wider. Doors count as open; leaf "
    "and handle are not taken off the clear width.",
    "In front of entrances a level landing is assumed, as wide as the chair needs to turn. Ways "
    "between entrances outside are not checked.",
    "A barrier opens a room if the planner finds a path after its door is widened or its furniture "
    "is removed on the map. Sets of up to three barriers are tried.",
    "A lift counts as usable if its doors and the outline of its car are large enough. Ramps "
    "between storeys are not followed.",
    "Values of norms are a comparison, no certificate. Read the text of the norm.",
)


def write_access(
    report: AccessReport, storeys: Sequence[BuildingStorey], file: Path, *, title: str
) -> None:
    """Write a report as one HTML file without external resources.

    Args:
        report: the answers.
        storeys: those of the building; the ones with rooms in the report are drawn.
        file: HTML file.
        title: name of the building.

    Raises:
        ConfigError: if the file cannot be written.
    """
    names = {storey.number: storey.name for storey in storeys}
    length, width = report.footprint
    page = render(
        "accessibility.html",
        title=f"Accessibility of {title}",
        facts={
            "Chair": f"{report.chair}, footprint {length:.2f} × {width:.2f} m",
            "Needed clear width": f"{width:.2f} m: width of the footprint, without extra clearance",
            "Circle to turn on the spot": f"{report.turning:.2f} m",
            "Entrance": "; ".join(f"{e.name}, {names[e.storey]}" for e in report.entrances),
            "Date": f"{date.today().isoformat()}, cohelm {version('cohelm')}",
        },
        summary=report.summary,
        rooms=_rooms(report, names),
        barriers=Table(
            ["barrier", "place", "cause", "opens alone", "opens with others"],
            [
                [str(b.number), b.place, b.text, _rooms_in(b.opens), _rooms_in(b.shares)]
                for b in report.barriers
            ],
        ),
        norms=Table(
            ["norm", "requirement", "verdict", "passes", "fails", "unknown", "failures"],
            [
                [
                    f"{n.rule.norm} {n.rule.clause}".strip(), n.rule.says, _verdict(n),
                    str(n.passes), str(len(n.failures)), str(n.unknown), "; ".join(n.failures),
                ]
                for n in report.norms
            ],
        ),
        plans=[
            (s.name, Markup(storey_svg(s, _marks(report, s.number))))
            for s in storeys
            if any(room.storey == s.number for room in report.rooms)
        ],
        limits=[*report.notes, *_LIMITS],
    )  # fmt: skip
    try:
        file.write_text(page, encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"{file} cannot be written ({cause})", key="--report") from cause


def access_record(report: AccessReport) -> dict[str, Any]:
    """Facts of a report for JSON; m."""
    return {
        "chair": report.chair,
        "footprint": list(report.footprint),
        "needed_width": report.footprint[1],
        "turning_circle": report.turning,
        "entrances": [
            {"name": e.name, "storey": e.storey, "door": e.door} for e in report.entrances
        ],
        "summary": report.summary,
        "rooms": [
            {
                "storey": r.storey, "id": r.room.id, "name": r.name, "reached": r.path is not None,
                "length": None if math.isnan(r.length) else r.length, "from": r.entrance,
                "tightest": r.tightest and {
                    "place": r.tightest.place, "point": r.tightest.point.tolist(),
                    "width": r.tightest.width, "margin": r.tightest.margin,
                },
                "turning_space": r.turning, "turns": r.turns,
                "barriers": [list(each) for each in r.barriers], "remark": r.remark,
                "path": None if r.path is None else r.path.tolist(),
            }
            for r in report.rooms
        ],
        "barriers": [
            {
                "number": b.number, "kind": b.fault.kind, "id": b.fault.id,
                "storey": b.fault.storey, "point": list(b.fault.point), "place": b.place,
                "text": b.text, "opens": list(b.opens), "shares": list(b.shares),
            }
            for b in report.barriers
        ],
        "norms": [
            {
                "norm": n.rule.norm, "clause": n.rule.clause, "requirement": n.rule.says,
                "verdict": _verdict(n), "passes": n.passes, "unknown": n.unknown,
                "failures": list(n.failures),
            }
            for n in report.norms
        ],
        "notes": list(report.notes),
    }  # fmt: skip


def _rooms(report: AccessReport, names: dict[int, str]) -> Table:
    rows: list[list[Content]] = []
    for room in report.rooms:
        tight, reached = room.tightest, room.path is not None
        rows.append(
            [
                TableCell(room.name, (names[room.storey],)),
                TableCell("yes", css="good") if reached else TableCell("no", css="bad"),
                f"from {room.entrance}" if reached else _reason(report, room),
                f"{room.length:.1f} m" if reached else "–",
                TableCell(f"{tight.width:.2f} m", (tight.place, f"{tight.margin:+.2f} m"))
                if tight
                else "–",
                TableCell(
                    f"{room.turning:.2f} m",
                    ("chair turns" if room.turns else "no turn on the spot",),
                ),
            ]
        )
    return Table(
        ["room", "reached", "way or reason", "distance", "tightest passage", "turning space"], rows,
        "tightest passage: clear width of a door, or free width on the map, and the margin beyond "
        "the chair; turning space: largest free circle (1.50 m in ISO 21542)",
    )  # fmt: skip


def _reason(report: AccessReport, room: RoomAccess) -> str:
    causes = {b.number: f"{b.place}: {b.text} (barrier {b.number})" for b in report.barriers}
    sets = [" and ".join(causes[number] for number in each) for each in room.barriers]
    return room.remark or "; or ".join(sets)


def _rooms_in(names: Sequence[str]) -> str:
    return f"{len(names)}: {'; '.join(names)}" if names else ""


def _verdict(check: Any) -> str:
    if check.failures:
        return "fails"
    return "unknown" if check.unknown else "passes"


def _marks(report: AccessReport, storey: int) -> AccessMarks:
    here = [room for room in report.rooms if room.storey == storey]
    return AccessMarks(
        reached={room.room.id: room.path is not None for room in here},
        paths=tuple(room.path for room in here if room.path is not None),
        barriers={b.number: b.fault.point for b in report.barriers if b.fault.storey == storey},
    )
