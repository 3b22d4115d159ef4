"""The best, the median and the worst ride of each contender, ridden again to be looked at."""

from __future__ import annotations

import base64
import io
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from cohelm.evaluation.episode import run
from cohelm.evaluation.results.again import task_of
from cohelm.evaluation.results.markup import Content, Markup, folded, table, tag
from cohelm.evaluation.results.page import section
from cohelm.evaluation.results.rides import Rides, Row, ended_badly, number
from cohelm.evaluation.results.summary import case_name
from cohelm.evaluation.ride import Ride
from cohelm.pictures import animate_ride, draw_ride

SECONDS_EACH = 0.5
"""That riding again may take for every ride of the sweep: a short sweep has a short report."""
WIDTH, FILM_WIDTH, FRAMES = 960, 640, 90
"""Of a picture and of a film, px, and the frames of a film at most."""
FILMS = 3_500_000
"""Bytes of all films after which no other is begun."""

Say = Callable[[str], None]


@dataclass(frozen=True)
class Choice:
    """A ride that stands for others."""

    which: str
    """``best``, ``median`` or ``worst``."""
    contender: str
    row: Row
    case: str


def choices(rides: Rides) -> list[Choice]:
    """Of each contender over all cases; rides that broke off are no choice.

    How it ended goes first: reached, not reached, collision. Then the time beside the time alone,
    then the least gap; among collisions, the speed at the touch.
    """
    out = []
    for name, group in rides.together().items():
        rows = sorted((row for row in group.rows if ended_badly(row) < 3), key=badness)
        at = {"best": 0, "median": (len(rows) - 1) // 2, "worst": len(rows) - 1}
        taken: set[int] = set()
        for which in ("worst", "best", "median"):  # of one ride or two, the worst is shown
            if rows and at[which] not in taken:
                taken.add(at[which])
                row = rows[at[which]]
                case = tuple(str(row.get(key)) for key in rides.by[:-1])
                out.append(Choice(which, name, row, case_name(case, rides.by)))
    return out


def badness(row: Row) -> tuple[float, ...]:
    """A ride's place from best to worst."""
    ratio = number(row.get("time")) / (number(row.get("time_alone")) or math.nan)
    ratio = number(row.get("time")) if math.isnan(ratio) else ratio
    touch = np.nan_to_num(number(row.get("collision_speed")))
    gap = np.nan_to_num(-number(row.get("min_distance")))
    return (ended_badly(row), touch, float(np.nan_to_num(ratio)), gap, number(row.get("seed")))


def shown(rides: Rides, base: str, seconds: float, say: Say) -> Markup:
    """A film of the worst ride, pictures of the others as time allows, and how to ride them again.

    Args:
        rides: to choose from.
        base: whose rides come first.
        seconds: after which no other ride is begun.
        say: is told what is being done.
    """
    found = choices(rides)
    if not found:
        return Markup("")
    until = time.monotonic() + min(seconds, SECONDS_EACH * len(rides))
    films, panels = _pictures(_in_turn(found, base), until, say)
    rows: list[list[Content]] = [_line(each) for each in found]
    columns = [rides.by[-1], "which", "case", "seed", "ended", "time, s", "least gap, m"]
    listed = [tag("li", _named(each), ": ", tag("code", str(each.row.get("replay")))) for each in
              found if each.row.get("replay")]  # fmt: skip
    drawn = len(films) + len(panels)
    why = "" if drawn >= len(found) else f"{drawn} of {len(found)} rides are shown. "
    return section(
        "rides", "Best, median and worst",
        tag("p", f"{why}{_HOW}", class_="soft"), table(columns, rows),
        folded("Commands that ride them again", tag("ul", listed)) if listed else "",
        tag("div", films, panels, class_="panels large") if drawn else "",
    )  # fmt: skip


_HOW = (
    "Rides are ordered by how they ended, then by how fast they touched somebody, then by their "
    "time beside the time alone. Pictures are of the same rides ridden again: dotted lines are "
    "people's ways, violet their personal space at the closest moment."
)


def _in_turn(found: Sequence[Choice], base: str) -> list[Choice]:
    """The worst first, then medians, then the best; of each the base's first."""
    order = {"worst": 0, "median": 1, "best": 2}
    return sorted(found, key=lambda each: (order[each.which], each.contender != base))


def _pictures(found: Sequence[Choice], until: float, say: Say) -> tuple[list[Markup], list[Markup]]:
    films: list[Markup] = []
    panels: list[Markup] = []
    for i, (choice, ride) in enumerate(_ridden(found, until)):
        say(f"pictures of rides: {i + 1} of {len(found)}")
        if choice.which == "worst" and sum(map(len, films)) < FILMS:
            films.append(_image(_film(ride), "gif", choice, ride, "film, 2.5 × as fast or more"))
        else:
            panels.append(_image(_picture(ride), "webp", choice, ride, "the whole ride"))
    return films, panels


def _ridden(found: Sequence[Choice], until: float) -> Iterator[tuple[Choice, Ride]]:
    for choice in found:
        task = task_of(choice.row)
        if time.monotonic() >= until:
            return
        if task is None:
            continue
        try:
            ride = run(task.load(), task.seed)
        except Exception:  # a picture less; its row stands in the table
            continue
        yield choice, ride


def _film(ride: Ride) -> bytes:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "ride.gif"
        animate_ride(ride, file, width=FILM_WIDTH, most=FRAMES)
        return file.read_bytes()


def _picture(ride: Ride) -> bytes:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "ride.png"
        draw_ride(ride, file)
        image = Image.open(file).convert("RGB")
    image.thumbnail((WIDTH, WIDTH))
    out = io.BytesIO()
    image.save(out, "webp", quality=72)
    return out.getvalue()


def _image(data: bytes, kind: str, choice: Choice, ride: Ride, what: str) -> Markup:
    source = f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
    now = ride.outcome.value
    moved = "" if now == choice.row.get("outcome") else f"; ridden again it ended in: {now}"
    says = f"{_named(choice)}, {what}{moved}"
    width, height = map(str, Image.open(io.BytesIO(data)).size)
    image = tag("img", src=source, alt=says, width=width, height=height, loading="lazy")
    return tag("figure", image, tag("figcaption", says), class_="map")


def _named(choice: Choice) -> str:
    where = f"{choice.case}, " if choice.case else ""
    ended = f"{choice.row.get('outcome')}"
    return f"{choice.contender}, {choice.which}: {where}seed {choice.row.get('seed')}, {ended}"


def _line(choice: Choice) -> list[Content]:
    row = choice.row
    figures = [number(row.get(key)) for key in ("time", "min_distance")]
    return [
        choice.contender,
        choice.which,
        choice.case,
        str(row.get("seed")),
        str(row.get("outcome")),
        *("–" if math.isnan(x) else f"{x:.2f}" for x in figures),
    ]
