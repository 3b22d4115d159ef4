"""``cohelm replay``: run the navigator on a recorded ride and compare its commands."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.cli import streams
from cohelm.cli.progress import Counting
from cohelm.cli.report import print_line, write_json
from cohelm.cli.requests import ReplayRequest
from cohelm.evaluation.code_version import differences, navigation_versions
from cohelm.evaluation.episode.open_loop import ReplayedTick, replay_ride
from cohelm.messages import Decision
from cohelm.recordings import RecordedRide

TOLERANCE = 1e-3
"""Allowed difference of commands where versions differ, m/s and rad/s."""


@dataclass
class _Differences:
    """Differences found so far; commands are kept only for a picture."""

    tolerance: float
    exact: bool
    """True: every bit counts."""
    commands: array[float] | None
    ticks: int = 0
    different: int = 0
    greatest: float = 0.0
    first: ReplayedTick | None = None
    intermediate: float | None = None
    """Time at which the intermediate results first differed, s; None: never."""
    reasons: int = 0
    last: float = 0.0

    @property
    def agrees(self) -> bool:
        """Check that commands, and with ``exact`` also intermediate results, agree."""
        return self.first is None and not (self.exact and self.intermediate is not None)

    def add(self, each: ReplayedTick) -> None:
        self.ticks += 1
        self.last = each.time
        same = each.same if self.exact else each.agrees(self.tolerance)
        if not same:
            self.different += 1
            self.first = self.first or each
        if self.intermediate is None and not each.same_inputs:
            self.intermediate = each.time
        self.greatest = max(self.greatest, each.difference)
        self.reasons += each.recorded.reason is not each.replayed.reason
        if self.commands is not None:
            self.commands.extend((each.time, *each.recorded.twist, *each.replayed.twist))


def replay(request: ReplayRequest) -> int:
    """Replay and compare; returns 0 where commands agree or settings were changed, else 1.

    Raises:
        CohelmError: if an option or the recording is at fault.
    """
    if request.plot is not None:
        from cohelm.plotting import check_picture

        check_picture(request.plot)
    settings = request.settings
    if request.planner is not None:
        settings = (f"local_planner={request.planner}", *settings)
    ride = RecordedRide(request.recording)
    changes = differences(ride.facts.versions, navigation_versions())
    tolerance = request.tolerance
    if tolerance is None:
        tolerance = TOLERANCE if changes else 0.0
    kept = array("d") if request.plot is not None else None
    count = _Differences(tolerance, exact=tolerance == 0.0, commands=kept)
    for each in _with_progress(replay_ride(ride, settings), request):
        count.add(each)
    if request.plot is not None:
        _draw(count, request.plot, settings)
    report = _report(ride, count, changes, settings)
    if request.json:
        write_json(report)
    else:
        _print(count, report, request)
    for text in ride.warnings:
        streams.say(f"warning: {text}")
    return 0 if settings or count.agrees else 1


def _with_progress(ticks: Iterator[ReplayedTick], request: ReplayRequest) -> Iterator[ReplayedTick]:
    with Counting(request.recording.name, None, shown=not request.json) as counting:
        yield from counting(ticks)


def _draw(count: _Differences, file: Path, settings: tuple[str, ...]) -> None:
    from cohelm.plotting import draw_replay

    rows = np.array(count.commands).reshape(-1, 7)
    first = None if count.first is None else count.first.time
    names = ", ".join(settings) if settings else "replayed"
    draw_replay(rows, file, _verdict(count), first=first, names=names[:80])


def _report(
    ride: RecordedRide, count: _Differences, changes: str, settings: tuple[str, ...]
) -> dict[str, Any]:
    first = count.first
    return {
        "recording": str(ride.file),
        "scenario": ride.facts.name,
        "seed": ride.facts.seed,
        "settings": list(settings),
        "ticks": count.ticks,
        "until": count.last,
        "different": count.different,
        "different_reasons": count.reasons,
        "greatest_difference": count.greatest,
        "tolerance": count.tolerance,
        "bit_equal": count.different == 0 and count.exact and count.intermediate is None,
        "first_intermediate_difference": count.intermediate,
        "first_difference": None
        if first is None
        else {
            "tick": first.number,
            "time": first.time,
            "recorded": _decision(first.recorded),
            "replayed": _decision(first.replayed),
        },
        "versions": dict(ride.facts.versions),
        "versions_changed": changes,
        "damage": list(ride.warnings),
    }


def _decision(each: Decision) -> dict[str, Any]:
    return {
        "twist": each.twist.tolist(),
        "reason": each.reason.value if each.reason else None,
        "emergency": each.emergency,
    }


def _print(count: _Differences, report: dict[str, Any], request: ReplayRequest) -> None:
    if report["versions_changed"]:
        changed = report["versions_changed"]
        print_line(f"recorded with other versions: {changed}")
    if count.first is not None:
        first = count.first
        print_line(f"first difference at {first.time:.2f} s, tick {first.number}:")
        for name, each in (("recorded", first.recorded), ("replayed", first.replayed)):
            print_line(f"  {name}  {_in_words(each)}")
        print_line(
            f"maximum difference {count.greatest:.6g} m/s or rad/s; "
            f"other reasons in {count.reasons} ticks"
        )
    if request.plot is not None:
        print_line(f"written: {request.plot}")
    sys.stdout.write(f"{_verdict(count)}\n")


def _verdict(count: _Differences) -> str:
    until = f"{count.ticks} ticks, {count.last:.1f} s"
    if count.first is not None:
        return f"different: {count.different} of {until}"
    if not count.agrees:
        since = f"{count.intermediate:.2f} s"
        return f"equal commands, but other intermediate results from {since}: {until}"
    if count.exact:
        return f"equal to the bit: {until}"
    return f"equal within {count.tolerance:g} m/s and rad/s: {until}"


def _in_words(each: Decision) -> str:
    v, side, turn = each.twist.tolist()
    sideways = f", {side!r} m/s to the left" if side else ""
    why = f" ({each.reason.value})" if each.reason else ""
    brakes = ", emergency" if each.emergency else ""
    return f"{v!r} m/s{sideways}, {turn!r} rad/s{why}{brakes}"
