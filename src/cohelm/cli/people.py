"""``cohelm people``: who is in a recording, frame by frame, as JSON, a table, a picture, a film."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.text import Text

from cohelm.cli import streams
from cohelm.cli.people_report import (
    facts_table,
    scores_json,
    scores_table,
    who_table,
    who_title,
)
from cohelm.cli.progress import Counting, Waiting
from cohelm.cli.report import OUTPUT, write_json
from cohelm.errors import ConfigError
from cohelm.evaluation.labelled import Scores, Scoring, read_truth
from cohelm.evaluation.watching import (
    NO_MAP,
    SPACING,
    Tracks,
    parts_of,
    perception_of,
    told,
    watch,
)
from cohelm.maps import OccupancyGrid, distance_field, read_map
from cohelm.recordings import Frame, Recording, open_recording

if TYPE_CHECKING:  # it draws: only where asked to
    from cohelm.evaluation.filming import Filming

TICK = 1e-6
"""Times that differ by less are one, s."""
AWAY = 0.5
"""A picture of an instant farther from the one asked for is worth a word, s."""


@dataclass(frozen=True)
class Asked:
    """What the options say."""

    recording: Path
    truth: Path | None = None
    map: str | None = None
    topic: str | None = None
    rate: float = 10.0
    """Of the sweeps in a folder, Hz."""
    start: float = 0.0
    """Since the recording's first frame, s."""
    seconds: float | None = None
    """How much of it; None: all."""
    settings: tuple[str, ...] = ()
    at_rest: bool = False
    """Whether a sensor of which the recording says nothing rests."""


@dataclass(frozen=True)
class Outputs:
    """What is to be written, and where."""

    json: bool = False
    plot: Path | None = None
    at: float | None = None
    """The instant of the picture since the recording's first frame, s; None: the busiest."""
    animate: Path | None = None


def people(asked: Asked, outputs: Outputs) -> int:
    """Say who is in a recording; returns 0, also where only part of it could be read.

    Raises:
        CohelmError: if what was asked cannot be done, or nothing can be read.
    """
    _check_outputs(outputs)
    parts = perception_of(asked.settings)
    grid = None if asked.map is None else read_map(asked.map)
    recording = open_recording(asked.recording, topic=asked.topic, rate=asked.rate)
    begin, every_frame = _begun(recording)
    scoring = _scoring(asked, begin)
    tracks = Tracks()
    filming = _filming(asked, outputs, grid, begin)
    walls = NO_MAP if grid is None else distance_field(grid)
    shown = not (outputs.json and sys.stdout.isatty())
    with Counting(recording.name, recording.frames, shown=shown) as counting:
        frames = _between(counting(every_frame), begin + asked.start, asked.seconds)
        picture = recording.frames == 1
        for seen in watch(frames, parts, walls, still=picture, at_rest=asked.at_rest):
            labels = None if scoring is None else scoring(seen)
            tracks.add(seen)
            if filming is not None:
                filming.add(seen, labels)
            if outputs.json and not _written(told(seen)):
                return streams.NOBODY_READS
    if not tracks.frames:
        raise ConfigError(_nothing_between(asked.start, asked.seconds), key="--start")
    scores = None if scoring is None else scoring.scores()
    _draw(filming, tracks, recording.name, outputs)
    _say(recording, tracks, begin, scores, outputs)
    _warn(asked, scores, outputs, filming)
    return 0


def _written(line: Mapping[str, Any]) -> bool:
    """Whether somebody still reads what is told, each frame as it comes."""
    try:
        write_json(line)
        sys.stdout.flush()
    except BrokenPipeError:  # typer would make an error of it
        streams.drop_output()
        return False
    return True


def _check_outputs(outputs: Outputs) -> None:
    """Refuse what cannot be written before working for it."""
    if outputs.plot is None and outputs.at is not None:
        raise ConfigError("says when the picture is taken: add --plot FILE.png", key="--at")
    if outputs.plot is not None or outputs.animate is not None:
        from cohelm.pictures import check_animation, check_picture  # noqa: PLC0415 # lazy

        if outputs.plot is not None:
            check_picture(outputs.plot)
        if outputs.animate is not None:
            check_animation(outputs.animate)


def _scoring(asked: Asked, begin: float) -> Scoring | None:
    if asked.truth is None:
        return None
    return Scoring(read_truth(asked.truth, asked.recording, begin))


def _filming(
    asked: Asked, outputs: Outputs, grid: OccupancyGrid | None, begin: float
) -> Filming | None:
    if outputs.plot is None and outputs.animate is None:
        return None
    from cohelm.evaluation.filming import Filming  # noqa: PLC0415 # lazy

    spacing = parts_of(asked.settings, SPACING)
    return Filming(
        **spacing, grid=grid, at=outputs.at, moving=outputs.animate is not None, begin=begin
    )


def _begun(frames: Iterable[Frame]) -> tuple[float, Iterator[Frame]]:
    """The time of the first frame, s, NaN without any; and all frames, the first included."""
    rest = iter(frames)
    first = next(rest, None)
    if first is None:
        return math.nan, rest
    return first.observation.time, chain([first], rest)


def _between(frames: Iterable[Frame], start: float, seconds: float | None) -> Iterator[Frame]:
    """The frames from the first at ``start`` on, until so many seconds of their clock are over."""
    begun = False
    for frame in frames:
        since = frame.observation.time - start
        if seconds is not None and since > seconds + TICK:
            return
        begun = begun or since >= -TICK
        if begun:  # a clock that runs back does not end it
            yield frame


def _nothing_between(start: float, seconds: float | None) -> str:
    if seconds is None:
        return "the recording ends before that"
    return f"the recording has no reading from {start:g} to {start + seconds:g} s"


def _draw(filming: Filming | None, tracks: Tracks, name: str, outputs: Outputs) -> None:
    if filming is None:
        return
    with Waiting("drawing"):
        if outputs.plot is not None:
            filming.draw(tracks, outputs.plot, name)
        if outputs.animate is not None:
            filming.animate(tracks, outputs.animate, name)


def _say(
    recording: Recording, tracks: Tracks, begin: float, scores: Scores | None, outputs: Outputs
) -> None:
    if outputs.json:
        if scores is not None:
            write_json({"scores": scores_json(scores)})
    else:
        tables = {recording.name: facts_table(tracks, begin)}
        if tracks.trails:
            tables[who_title(tracks)] = who_table(tracks, begin)
        if scores is not None:
            tables["against the labels"] = scores_table(scores)
        for title, table in tables.items():
            OUTPUT.print(Text(title, style="bold"), soft_wrap=True)
            OUTPUT.print(table)
        for file in (outputs.plot, outputs.animate):
            if file is not None:
                OUTPUT.print(f"written: {file}", markup=False, soft_wrap=True)
    for warning in recording.warnings:
        streams.say(f"warning: {warning}")


def _warn(asked: Asked, scores: Scores | None, outputs: Outputs, filming: Filming | None) -> None:
    """Say where what came out is hardly what was meant."""
    if scores is not None and not scores.instants:
        streams.say(f"warning: {asked.truth}: says of no instant of the recording who was there")
    elif scores is not None and scores.labels and not scores.found:
        streams.say(
            f"warning: {asked.truth}: nobody is near any label: are they of {asked.recording}?"
        )
    if filming is not None and outputs.at is not None and abs(filming.at - outputs.at) > AWAY:
        streams.say(f"warning: --at {outputs.at:g}: the nearest reading is at {filming.at:.1f} s")
