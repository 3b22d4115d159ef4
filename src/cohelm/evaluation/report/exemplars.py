"""Exemplar rides: the best, median and worst ride of each contender, repeated for pictures."""

from __future__ import annotations

import base64
import io
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from markupsafe import Markup
from PIL import Image

from cohelm.evaluation.episode.episode import run
from cohelm.evaluation.episode.ride import Ride
from cohelm.evaluation.metrics.measures import measure_info
from cohelm.evaluation.report.figures import ReportFigure
from cohelm.evaluation.report.html import Content, Table
from cohelm.evaluation.report.rides import Rides, Row, number, severity
from cohelm.evaluation.report.summary import case_name
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.plotting import AnimationStyle, animate_ride, draw_ride

SECONDS_EACH = 0.5
"""Time for repeating rides, for each ride of the sweep, s."""
WIDTH, FILM_WIDTH, FRAMES = 960, 640, 90
"""Width of a picture and of a film, px, and largest number of frames."""
FILMS = 3_500_000
"""Size of all films after which no further one is made, bytes."""

Say = Callable[[str], None]


@dataclass(frozen=True)
class Exemplar:
    """Ride that represents others."""

    rank: str
    """``best``, ``median`` or ``worst``."""
    contender: str
    row: Row
    case: str

    def __str__(self) -> str:
        """Contender, rank, case, seed and outcome."""
        where = f"{self.case}, " if self.case else ""
        ride = f"{where}seed {self.row.get('seed')}, {self.row.get('outcome')}"
        return f"{self.contender}, {self.rank}: {ride}"


@dataclass(frozen=True)
class ExemplarReport:
    """Exemplar rides of a report."""

    table: Table
    commands: Sequence[tuple[str, str]]
    """Ride, and the command that repeats it."""
    shown: str = ""
    pictures: list[ReportFigure] = field(default_factory=list)


def exemplars(rides: Rides) -> list[Exemplar]:
    """Exemplars of each contender over all cases; rides with a program error are none."""
    out = []
    for name, group in rides.by_contender().items():
        rows = sorted((row for row in group.rows if severity(row) < 3), key=badness)
        at = {"best": 0, "median": (len(rows) - 1) // 2, "worst": len(rows) - 1}
        taken: set[int] = set()
        for rank in ("worst", "best", "median"):  # of one ride or two, the worst is shown
            if rows and at[rank] not in taken:
                taken.add(at[rank])
                row = rows[at[rank]]
                case = tuple(str(row.get(key)) for key in rides.by[:-1])
                out.append(Exemplar(rank, name, row, case_name(case, rides.by)))
    return out


def badness(row: Row) -> tuple[float, ...]:
    """Sort key from best to worst: outcome, speed at a collision, time ratio, smallest gap."""
    ratio = number(row.get("time")) / (number(row.get("time_empty_floor")) or math.nan)
    ratio = number(row.get("time")) if math.isnan(ratio) else ratio
    speed = np.nan_to_num(number(row.get("collision_speed")))
    gap = np.nan_to_num(-number(row.get("min_distance")))
    return (severity(row), speed, float(np.nan_to_num(ratio)), gap, number(row.get("seed")))


def exemplar_report(rides: Rides, base: str, seconds: float, say: Say) -> ExemplarReport | None:
    """Table of the exemplars, films of the worst and pictures of the others; None without any.

    Args:
        rides: all rides.
        base: contender whose pictures come first.
        seconds: time after which no further ride is repeated.
        say: receives progress messages.
    """
    found = exemplars(rides)
    if not found:
        return None
    until = time.monotonic() + min(seconds, SECONDS_EACH * len(rides))
    order = {"worst": 0, "median": 1, "best": 2}
    turns = sorted(found, key=lambda each: (order[each.rank], each.contender != base))
    pictures = _pictures(turns, until, say)
    measures = ("time", "min_distance")
    headings = [measure_info(name).heading for name in measures]
    rows: list[list[Content]] = [
        [
            each.contender, each.rank, each.case, str(each.row.get("seed")),
            str(each.row.get("outcome")),
            *(measure_info(name).text(number(each.row.get(name))) for name in measures),
        ]
        for each in found
    ]  # fmt: skip
    all_shown = len(pictures) >= len(found)
    return ExemplarReport(
        table=Table([rides.by[-1], "rank", "case", "seed", "outcome", *headings], rows),
        commands=[(str(e), str(e.row["replay"])) for e in found if e.row.get("replay")],
        shown="" if all_shown else f"{len(pictures)} of {len(found)} rides are shown. ",
        pictures=pictures,
    )


def _pictures(found: Sequence[Exemplar], until: float, say: Say) -> list[ReportFigure]:
    films: list[ReportFigure] = []
    stills: list[ReportFigure] = []
    for i, (exemplar, ride) in enumerate(_repeated(found, until)):
        say(f"pictures of rides: {i + 1} of {len(found)}")
        if exemplar.rank == "worst" and sum(len(each.content) for each in films) < FILMS:
            films.append(_image(_film(ride), "gif", exemplar, ride, "film"))
        else:
            stills.append(_image(_picture(ride), "webp", exemplar, ride, "whole ride"))
    return films + stills


def _repeated(found: Sequence[Exemplar], until: float) -> Iterator[tuple[Exemplar, Ride]]:
    for exemplar in found:
        task = RideTask.from_row(exemplar.row)
        if time.monotonic() >= until:
            return
        if task is None:
            continue
        try:
            ride = run(task.load(), task.seed)
        except Exception:  # another version may fail in any way; the row stays in the table
            continue
        yield exemplar, ride


def _film(ride: Ride) -> bytes:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "ride.gif"
        style = AnimationStyle(width=FILM_WIDTH, max_frames=FRAMES, speed_up=2.5)
        animate_ride(ride, file, style=style)
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


def _image(data: bytes, kind: str, exemplar: Exemplar, ride: Ride, what: str) -> ReportFigure:
    source = f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
    now = ride.outcome.value
    changed = "" if now == exemplar.row.get("outcome") else f"; outcome when repeated: {now}"
    caption = f"{exemplar}, {what}{changed}"
    width, height = Image.open(io.BytesIO(data)).size
    image = Markup('<img src="{}" alt="{}" width="{}" height="{}" loading="lazy">')
    return ReportFigure(image.format(source, caption, width, height), caption, is_map=True)
