"""``cohelm replay``: a recorded ride again, and where the commands differ."""

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
from cohelm.cli.report import OUTPUT, write_json
from cohelm.evaluation.open_loop import Compared, replayed
from cohelm.evaluation.recorded import ride_versions
from cohelm.evaluation.sweeps.identity import differences
from cohelm.messages import Decision
from cohelm.recordings import RecordedRide

TOLERANCE = 1e-3
"""What commands may differ by where versions do, m/s and rad/s."""


@dataclass(frozen=True)
class Asked:
    """What the options say."""

    file: Path
    settings: tuple[str, ...] = ()
    planner: str | None = None
    tolerance: float | None = None
    """m/s and rad/s; None: none where all versions agree, else ``TOLERANCE``."""
    json: bool = False
    plot: Path | None = None


@dataclass
class _Count:
    """What has been found so far; a few numbers for each tick, for the picture alone."""

    tolerance: float
    exact: bool
    """Whether anything but the same to the bit is a difference."""
    commands: array[float] | None
    ticks: int = 0
    different: int = 0
    greatest: float = 0.0
    first: Compared | None = None
    parted: float | None = None
    """When what led to a command first differed, s; None: never."""
    reasons: int = 0
    last: float = 0.0

    @property
    def agrees(self) -> bool:
        """Whether nothing differs that is not to differ."""
        return self.first is None and not (self.exact and self.parted is not None)

    def add(self, each: Compared) -> None:
        self.ticks += 1
        self.last = each.time
        same = each.same if self.exact else each.agrees(self.tolerance)
        if not same:
            self.different += 1
            self.first = self.first or each
        if self.parted is None and not each.same_way:
            self.parted = each.time
        self.greatest = max(self.greatest, each.difference)
        self.reasons += each.then.reason is not each.now.reason
        if self.commands is not None:
            self.commands.extend((each.time, *each.then.twist, *each.now.twist))


def replay(asked: Asked) -> int:
    """Ride again and compare; returns 0 where the commands agree or others were asked for, else 1.

    Raises:
        CohelmError: if what was asked cannot be done.
    """
    if asked.plot is not None:
        from cohelm.pictures import check_picture  # noqa: PLC0415 # lazy

        check_picture(asked.plot)
    settings = asked.settings
    if asked.planner is not None:
        settings = (f"local_planner={asked.planner}", *settings)
    ride = RecordedRide(asked.file)
    changes = differences(ride.facts.versions, ride_versions())
    tolerance = asked.tolerance
    if tolerance is None:
        tolerance = TOLERANCE if changes else 0.0
    kept = array("d") if asked.plot is not None else None
    count = _Count(tolerance, exact=tolerance == 0.0, commands=kept)
    for each in _shown(replayed(ride, settings), asked):
        count.add(each)
    if asked.plot is not None:
        _draw(count, asked.plot, settings)
    report = _report(ride, count, changes, settings)
    if asked.json:
        write_json(report)
    else:
        _say(count, report, asked)
    for text in ride.warnings:
        streams.say(f"warning: {text}")
    return 0 if settings or count.agrees else 1


def _shown(ticks: Iterator[Compared], asked: Asked) -> Iterator[Compared]:
    with Counting(asked.file.name, None, shown=not asked.json) as counting:
        yield from counting(ticks)


def _draw(count: _Count, file: Path, settings: tuple[str, ...]) -> None:
    from cohelm.pictures.replay import draw_replay  # noqa: PLC0415 # lazy

    rows = np.array(count.commands).reshape(-1, 7)
    first = None if count.first is None else count.first.time
    names = ", ".join(settings) if settings else "replayed"
    draw_replay(rows, file, _verdict(count), first=first, names=names[:80])


def _report(
    ride: RecordedRide, count: _Count, changes: str, settings: tuple[str, ...]
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
        "same_to_the_bit": count.different == 0 and count.exact and count.parted is None,
        "first_other_way": count.parted,
        "first_difference": None
        if first is None
        else {
            "tick": first.number,
            "time": first.time,
            "recorded": _decision(first.then),
            "replayed": _decision(first.now),
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


def _say(count: _Count, report: dict[str, Any], asked: Asked) -> None:
    if report["versions_changed"]:
        changed = report["versions_changed"]
        OUTPUT.print(f"recorded with other versions: {changed}", markup=False)
    if count.first is not None:
        first = count.first
        OUTPUT.print(f"first at {first.time:.2f} s, tick {first.number}:", markup=False)
        for name, each in (("recorded", first.then), ("replayed", first.now)):
            OUTPUT.print(f"  {name}  {_in_words(each)}", markup=False)
        OUTPUT.print(
            f"greatest difference {count.greatest:.6g} m/s or rad/s; "
            f"another reason in {count.reasons} ticks",
            markup=False,
        )
    if asked.plot is not None:
        OUTPUT.print(f"written: {asked.plot}", markup=False)
    sys.stdout.write(f"{_verdict(count)}\n")


def _verdict(count: _Count) -> str:
    until = f"{count.ticks} ticks, {count.last:.1f} s"
    if count.first is not None:
        return f"different: {count.different} of {until}"
    if not count.agrees:
        return (
            f"the same commands, but seen or planned otherwise from {count.parted:.2f} s: {until}"
        )
    if count.exact:
        return f"the same to the bit: {until}"
    return f"the same within {count.tolerance:g} m/s and rad/s: {until}"


def _in_words(each: Decision) -> str:
    v, side, turn = each.twist.tolist()
    sideways = f", {side!r} m/s to the left" if side else ""
    why = f" ({each.reason.value})" if each.reason else ""
    brakes = ", emergency" if each.emergency else ""
    return f"{v!r} m/s{sideways}, {turn!r} rad/s{why}{brakes}"
