"""Report of faults: detection, delay, stopping distance, contacts, false alarms, hazards.

``HAZARDS`` says of each fault what it does and what remains, for the table of failure modes.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Sheet
from cohelm.benchmarks.rides.false_alarms import alarm_note
from cohelm.evaluation.report.statistics import bootstrap_median, wilson_share
from cohelm.simulation import FAULT_KINDS


class Hazard(NamedTuple):
    """Entry of a failure mode."""

    effect: str
    residual: str
    detectable: bool = True
    """False: no redundant input reveals it in time, for the reason in ``residual``."""
    except_at: tuple[float, ...] = ()
    """Magnitudes at which it is not reliably detectable either, for the same reason."""

    def detectable_at(self, magnitude: float) -> bool:
        """Check that a magnitude is detectable."""
        return self.detectable and magnitude not in self.except_at


_BRAKING = "the distance of braking from the speed at the onset"
_UNSTOPPABLE = (
    "the wheels no longer obey: detected, but only a relay in the motor supply stops them"
)

HAZARDS: Mapping[str, Hazard] = MappingProxyType(
    {
        "scan_frozen": Hazard("people and chair seem to stand still", _BRAKING),
        "scan_constant": Hazard("nothing real is seen", _BRAKING),
        "scan_nan": Hazard("nothing is seen", _BRAKING),
        "scan_blind": Hazard("nothing is seen ahead", "gaps narrower than 9° stay unnoticed"),
        "scan_free_sector": Hazard(
            "people ahead are missed",
            "in halls wider than the scanner's range only who was seen before within 6 m tells a "
            "lost beam from a free path",
            except_at=(20.0, 45.0),
        ),
        "scan_free_beams": Hazard("thin things are missed", "25 % lost beams may pass as glass"),
        "scan_scaled": Hazard("people seem farther or nearer", "scales within 10 % near walls"),
        "scan_spots": Hazard("phantom obstacles", "too many stops; never a missed person", False),
        "scan_multipath": Hazard("ghost spaces behind walls", "people are still seen in front"),
        "scan_glass": Hazard("walls are missed", "panes narrower than 9° ahead"),
        "scan_sunlight": Hazard("a sector is dazzled", "sectors narrower than 9° ahead"),
        "scan_silent": Hazard("nothing new is seen", _BRAKING),
        "scan_delayed": Hazard("people are seen late", "0.2 s is within the gate's bound", False),
        "scan_restamped": Hazard(
            "people are seen late", "0.2 s shifts the scan less than the map's tolerance"
        ),
        "scan_out_of_order": Hazard(
            "every second sweep is dropped", "people are seen 0.1 s later", False
        ),
        "scan_mirrored": Hazard("left and right change places", _BRAKING),
        "scan_rotated": Hazard("everything is seen in a wrong direction", "turns below 4°"),
        "cloud_frozen": Hazard("floor and people seem to stand still", _BRAKING, False),
        "cloud_covered": Hazard("floor and people are not seen", _BRAKING, False),
        "cloud_tilted": Hazard(
            "the floor seems to slope", "a step is still a step; beyond 6° floor is an edge", False
        ),
        "cloud_raised": Hazard("the floor seems lower", "none: a step is still a step", False),
        "pose_silent": Hazard("place unknown", _BRAKING),
        "pose_frozen": Hazard("place wrong", _BRAKING),
        "pose_nan": Hazard("place unknown", _BRAKING),
        "pose_jump": Hazard("walls are expected in wrong places", "live obstacles still count"),
        "pose_drift": Hazard("walls are expected in wrong places", "0.2 m of drift, driven slowly"),
        "pose_turn_drift": Hazard("the chair turns off its path", "4° of drift, driven slowly"),
        "pose_overconfident": Hazard("walls are expected in wrong places", "errors below 0.2 m"),
        "kidnapped": Hazard(
            "walls are expected in wrong places", "along featureless corridors; below 0.3 m"
        ),
        "twist_silent": Hazard("speed unknown", _BRAKING),
        "twist_frozen": Hazard("speed wrong", "until the speed should change"),
        "twist_nan": Hazard("speed unknown", _BRAKING),
        "twist_zero": Hazard("stopping distance underrated", _BRAKING),
        "twist_scaled": Hazard("stopping distance wrong", "scales within 20 % take seconds"),
        "wheel_slip": Hazard("the chair moves less than its wheels", "slip of 20 % takes seconds"),
        "command_stuck": Hazard("the chair drives on", _UNSTOPPABLE, False),
        "command_dead": Hazard("the chair stops", "none: it stands"),
        "command_delayed": Hazard(
            "late braking",
            "0.15 s is within the gate's reaction time; longer ones show only when "
            "the speed changes",
            False,
        ),
        "command_dropped": Hazard(
            "late braking",
            "shows only when the speed changes; nine of ten dropped act as a delay",
            False,
        ),
        "command_scaled": Hazard("too fast, or in reverse", _UNSTOPPABLE, False),
        "command_flipped": Hazard("turns in the wrong direction", _BRAKING),
        "motor_weak": Hazard(
            "the chair pulls to one side", "control steers a loss of 30 % out", detectable=False
        ),
        "brake_slow": Hazard(
            "stopping distance too long", "shows only in hard braking, when it is needed", False
        ),
        "battery_sag": Hazard("slower than commanded", "none: it is slower"),
        "rider_silent": Hazard("the chair drives on", _BRAKING),
        "rider_nan": Hazard("the chair drives on", _BRAKING),
        "rider_stuck": Hazard(
            "the chair drives where nobody steers",
            "a key is as constant as a broken stick: only the gate stops before obstacles, and "
            "8 s of standing against one",
            False,
        ),
        "rider_repeated": Hazard("the chair drives where nobody steers", "as a stuck stick", False),
        "rider_off_centre": Hazard(
            "the chair veers", "looks like a rider who steers a little: only the gate stops", False
        ),
        "people_ghost": Hazard("the chair waits for nobody", "looks like a person", False),
        "people_lost": Hazard(
            "a person is not seen",
            "noticed if the person was seen free within 6 m before; else no sensor has a trace",
            False,
        ),
        "people_swapped": Hazard("predictions restart", "ids are not used for contact", False),
        "late": Hazard("old decisions", _BRAKING),
        "clock_backwards": Hazard("ages are wrong", _BRAKING),
        "clock_forwards": Hazard(
            "all input seems old", "steps below 0.2 s look like latency", True
        ),
    }
)


SOFT, HARD = 0.1, 0.3
"""Speeds of a contact, m/s: what the figures count, and what no detectable fault may exceed."""
STEP = 0.06
"""Longest time from the end of a ride to an onset that it still reached, s."""
CARRIED = 0.2
"""Step from which a chair was carried, m; it drives 0.04 m."""
NONE = "none"
TABLE = "hazards.md"
Row = Mapping[str, Any]
Case = tuple[str, str]


def fault_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Tables of all faults, and the table of hazards as a Markdown file."""
    ridden = [r.row for r in results if not r.row["error"]]
    failed = [r.row for r in results if r.row["error"]]
    rows = [row for row in ridden if float(row["duration"]) >= float(row["onset"]) - STEP]
    watched = _by_case([row for row in rows if row["monitor"] == "on"])
    before = _by_case([row for row in rows if row["monitor"] == "off"])
    sound = watched.pop((NONE, "nan"), [])
    before.pop((NONE, "nan"), None)
    reference = {_pair(row): row for row in sound}
    sheets = [detection_sheet(watched), contact_sheet(watched, before, reference)]
    text = hazard_table(watched, before, reference)
    file = folder / TABLE
    file.write_text(text, encoding="utf-8")
    sure = {
        case: group
        for case, group in watched.items()
        if HAZARDS[case[0]].detectable_at(float(case[1]))
    }
    broken = {
        f"{kind} {size}": speed
        for (kind, size), group in sure.items()
        if (speed := max(_speeds(group, reference))) > HARD
    }
    return BenchReport(
        sheets=tuple(sheet for sheet in sheets if sheet.rows),
        notes=(
            f"{sum(map(len, watched.values()))} faulted rides, {len(failed)} with program errors",
            f"{len(ridden) - len(rows)} more ended before the fault",
            f"{_undecided(watched)} ended before the fault was noticed, because a person walked "
            "into the standing chair, or had no place to carry it to: they do not count as missed",
            *detectable_notes([row for group in sure.values() for row in group], reference),
            alarm_note(sound),
            *(f"contact at {v:.2f} m/s although detectable: {k}" for k, v in broken.items()),
            *([] if broken else ["no contact above 0.3 m/s by a fault that is detectable"]),
        ),
        summary={
            "rides": sum(map(len, watched.values())),
            "errors": len(failed),
            "cases": {
                f"{kind} {size}": _figures(group, reference)
                for (kind, size), group in watched.items()
            },
        },
        files=(file,),
    )


def detection_sheet(watched: Mapping[Case, Sequence[Row]]) -> Sheet:
    """Share of rides in which a fault was noticed, its delay, and the way to a standstill."""
    rows = []
    for (kind, size), group in watched.items():
        share = wilson_share(_column(_decided(group), "noticed") > 0.0)
        delay = bootstrap_median(_column(group, "delay"))
        stop = _column(group, "stop_distance")
        stopped = stop[np.isfinite(stop)]
        rows.append(
            (
                kind,
                _size(kind, size),
                str(len(group)),
                f"{share.mean:.2f} [{share.low:.2f}, {share.high:.2f}]",
                f"{delay.mean:.2f} [{delay.low:.2f}, {delay.high:.2f}]" if delay.count else "–",
                f"{np.median(stopped):.2f}, {stopped.max():.2f}" if len(stopped) else "–",
                _reasons(group),
            )
        )
    return Sheet(
        title="detection",
        columns=(
            *("fault", "magnitude", "rides", "noticed [95 %]", "delay, s, median [95 %]"),
            *("way to standstill, m, median, max", "noticed by"),
        ),
        rows=tuple(rows),
    )


def contact_sheet(
    watched: Mapping[Case, Sequence[Row]],
    before: Mapping[Case, Sequence[Row]],
    reference: Mapping[tuple[Any, ...], Row],
) -> Sheet:
    """Rides with a contact that the ride without the fault does not have."""
    rows = []
    for case, group in watched.items():
        speeds, off = _speeds(group, reference), _speeds(before.get(case, ()), reference)
        rows.append(
            (
                case[0],
                _size(*case),
                _count(off, SOFT),
                _count(speeds, SOFT),
                _count(off, HARD),
                _count(speeds, HARD),
                f"{max(off, default=0.0):.2f} → {max(speeds, default=0.0):.2f}",
            )
        )
    return Sheet(
        title="rides with a contact caused by the fault, without and with the monitor",
        columns=(
            *("fault", "magnitude", f"> {SOFT:g} m/s, off", f"> {SOFT:g} m/s, on"),
            *(f"> {HARD:g} m/s, off", f"> {HARD:g} m/s, on", "largest speed, m/s"),
        ),
        rows=tuple(rows),
    )


def detectable_notes(
    group: Sequence[Row], reference: Mapping[tuple[Any, ...], Row]
) -> tuple[str, ...]:
    """Sentences on the rides whose fault is listed as detectable, with intervals of 95 %."""
    if not group:
        return ()
    speeds = np.array(_speeds(group, reference))
    noticed = wilson_share(_column(_decided(group), "noticed") > 0.0)
    soft, hard = (wilson_share(np.asarray(speeds > bound)) for bound in (SOFT, HARD))
    return (
        f"{len(group)} rides with a fault listed as detectable, noticed: {noticed:.3f}",
        f"of these with a contact above {SOFT:g} m/s: {int((speeds > SOFT).sum())} ({soft:.4f}), "
        f"above {HARD:g} m/s: {int((speeds > HARD).sum())} ({hard:.4f})",
    )


def hazard_table(
    watched: Mapping[Case, Sequence[Row]],
    before: Mapping[Case, Sequence[Row]],
    reference: Mapping[tuple[Any, ...], Row],
) -> str:
    """Failure modes and effects as a Markdown table, from the rides."""
    kinds: dict[str, list[Row]] = defaultdict(list)
    unwatched: dict[str, list[Row]] = defaultdict(list)
    for (kind, _), group in watched.items():
        kinds[kind] += group
    for (kind, _), group in before.items():
        unwatched[kind] += group
    lines = [
        "| cause | effect | detected | delay, s | detection by | contacts > 0.1 m/s, off → on "
        "| largest, m/s | residual |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for kind, group in kinds.items():
        hazard = HAZARDS[kind]
        delay = _column(group, "delay")
        found = delay[np.isfinite(delay)]
        speeds, off = _speeds(group, reference), _speeds(unwatched.get(kind, ()), reference)
        noticed = int(_column(group, "noticed").sum())
        median = f"{np.median(found):.2f}" if len(found) else "–"
        lines.append(
            f"| `{kind}`: {FAULT_KINDS[kind].text} | {hazard.effect} "
            f"| {noticed} of {len(_decided(group))} | {median} | {_reasons(group) or '–'} "
            f"| {_count(off, SOFT)} → {_count(speeds, SOFT)} | {max(speeds):.2f} "
            f"| {_proviso(hazard)}{hazard.residual} |"
        )
    return "\n".join(lines) + "\n"


def _proviso(hazard: Hazard) -> str:
    """Beginning of the residual: is the fault detectable, and at every magnitude."""
    if not hazard.detectable:
        return "not reliably detectable: "
    if hazard.except_at:
        return f"not reliably detectable at {', '.join(f'{m:g}' for m in hazard.except_at)}: "
    return ""


def _by_case(rows: Sequence[Row]) -> dict[Case, list[Row]]:
    out: dict[Case, list[Row]] = defaultdict(list)
    for row in rows:
        out[str(row["fault"]), str(row["magnitude"])].append(row)
    return out


def _decided(group: Sequence[Row]) -> list[Row]:
    """Rides that show whether the fault is noticed.

    Others were ended by a person before, or had no place to which the chair could be carried.
    """
    return [
        row
        for row in group
        if float(row["noticed"]) or not (float(row["walked_into"]) or _stayed(row))
    ]


def _stayed(row: Row) -> bool:
    """Check for a chair that should have been carried, and was not."""
    return row["fault"] == "kidnapped" and float(row["largest_step"]) < CARRIED


def _undecided(watched: Mapping[Case, Sequence[Row]]) -> int:
    return sum(len(group) - len(_decided(group)) for group in watched.values())


def _pair(row: Row) -> tuple[Any, ...]:
    return row["scene"], row["mode"], int(row["seed"])


def _speeds(group: Sequence[Row], reference: Mapping[tuple[Any, ...], Row]) -> list[float]:
    """Contact speeds, m/s; 0 without a contact, and where the sound ride has one as well."""
    out = []
    for row in group:
        sound = reference.get(_pair(row))
        shared = sound is not None and float(sound["contact_speed"]) > SOFT
        out.append(0.0 if shared else float(row["contact_speed"]))
    return out


def _column(group: Sequence[Row], name: str) -> Floats:
    return np.array([float(row[name]) for row in group], dtype=float)


def _count(speeds: Sequence[float], above: float) -> str:
    return f"{sum(v > above for v in speeds)} of {len(speeds)}" if speeds else "–"


def _size(kind: str, size: str) -> str:
    return "" if size == "nan" else f"{size} {FAULT_KINDS[kind].unit}".strip()


def _reasons(group: Sequence[Row]) -> str:
    """Most frequent first reasons."""
    names = [str(row["noticed_by"]) for row in group if row["noticed_by"]]
    ordered = sorted(set(names), key=lambda each: (-names.count(each), each))
    return ", ".join(ordered[:3])


def _figures(group: Sequence[Row], reference: Mapping[tuple[Any, ...], Row]) -> Mapping[str, Any]:
    delay = _column(group, "delay")
    found = delay[np.isfinite(delay)]
    return {
        "rides": len(group),
        "noticed": float(_column(_decided(group), "noticed").mean()),
        "delay": float(np.median(found)) if len(found) else math.nan,
        "contact_speed": max(_speeds(group, reference)),
    }
