"""``cohelm people``: people in a recording, as JSON for each frame, a table, a picture, a film."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any

from rich.text import Text

from cohelm.cli import streams
from cohelm.cli.people_report import (
    facts_table,
    people_table,
    people_title,
    scores_json,
    scores_table,
)
from cohelm.cli.progress import Counting, waiting
from cohelm.cli.report import OUTPUT, print_line, write_json
from cohelm.cli.requests import PeopleRequest
from cohelm.errors import ConfigError
from cohelm.evaluation.perception.labelled import LabelScores, LabelScoring, read_label_source
from cohelm.evaluation.perception.recording_view import (
    NO_MAP,
    PREDICTION_PARTS,
    RecordingSummary,
    frame_record,
    parts_of,
    perceive_frames,
    perception_of,
)
from cohelm.maps import OccupancyGrid, distance_field, read_map
from cohelm.recordings import Frame, SensorRecording, open_recording
from cohelm.robots import load_robot

if TYPE_CHECKING:  # it draws: only where asked to
    from cohelm.evaluation.perception.film import FilmRecorder

TICK = 1e-6
"""Times that differ by less are equal, s."""
AWAY = 0.5
"""Warn if the picture is farther than this from the requested instant, s."""


def people(request: PeopleRequest) -> int:
    """Track people and print them; returns 0, also where only part of the file could be read.

    Raises:
        CohelmError: if an option is at fault, or nothing can be read.
    """
    _check_outputs(request)
    outline = None if request.robot is None else load_robot(request.robot).outline
    parts = perception_of(request.settings, outline)
    grid = None if request.map is None else read_map(request.map)
    recording = open_recording(request.recording, topic=request.topic, rate=request.rate)
    begin, every_frame = _peek(recording)
    scoring = _scoring(request, begin)
    tracks = RecordingSummary()
    filming = _filming(request, grid, begin)
    walls = NO_MAP if grid is None else distance_field(grid)
    shown = not (request.json and sys.stdout.isatty())
    with Counting(recording.name, recording.frames, shown=shown) as counting:
        frames = _between(counting(every_frame), begin + request.start, request.seconds)
        picture = recording.frames == 1
        for seen in perceive_frames(frames, parts, walls, still=picture, at_rest=request.still):
            labels = None if scoring is None else scoring(seen)
            tracks.add(seen)
            if filming is not None:
                filming.add(seen, labels)
            if request.json and not _written(frame_record(seen)):
                return streams.BROKEN_PIPE
    if not tracks.frames:
        raise ConfigError(_nothing_between(request.start, request.seconds), key="--start")
    scores = None if scoring is None else scoring.scores()
    _draw(filming, tracks, recording.name, request)
    _print(recording, tracks, begin, scores, request)
    _warn(request, scores, filming)
    return 0


def _written(line: Mapping[str, Any]) -> bool:
    """Write one frame; False where the reader of the output has gone."""
    try:
        write_json(line)
        sys.stdout.flush()
    except BrokenPipeError:  # typer would turn it into an error
        streams.drop_output()
        return False
    return True


def _check_outputs(request: PeopleRequest) -> None:
    """Refuse outputs that cannot be written, before the work."""
    if request.plot is None and request.at is not None:
        raise ConfigError("needs a picture: add --plot FILE.png", key="--at")
    if request.plot is not None or request.animate is not None:
        from cohelm.plotting import check_animation, check_picture

        if request.plot is not None:
            check_picture(request.plot)
        if request.animate is not None:
            check_animation(request.animate)


def _scoring(request: PeopleRequest, begin: float) -> LabelScoring | None:
    if request.truth is None:
        return None
    return LabelScoring(read_label_source(request.truth, request.recording, begin))


def _filming(
    request: PeopleRequest, grid: OccupancyGrid | None, begin: float
) -> FilmRecorder | None:
    if request.plot is None and request.animate is None:
        return None
    from cohelm.evaluation.perception.film import FilmRecorder

    spacing = parts_of(request.settings, PREDICTION_PARTS)
    return FilmRecorder(
        **spacing, grid=grid, at=request.at, moving=request.animate is not None, begin=begin
    )


def _peek(frames: Iterable[Frame]) -> tuple[float, Iterator[Frame]]:
    """Time of the first frame, s (NaN without frames), and all frames, the first included."""
    rest = iter(frames)
    first = next(rest, None)
    if first is None:
        return math.nan, rest
    return first.observation.time, chain([first], rest)


def _between(frames: Iterable[Frame], start: float, seconds: float | None) -> Iterator[Frame]:
    """Frames from the first at ``start`` on, for ``seconds`` of their clock."""
    begun = False
    for frame in frames:
        since = frame.observation.time - start
        if seconds is not None and since > seconds + TICK:
            return
        begun = begun or since >= -TICK
        if begun:  # a clock that jumps back does not end it
            yield frame


def _nothing_between(start: float, seconds: float | None) -> str:
    if seconds is None:
        return "the recording ends before that"
    return f"the recording has no reading from {start:g} to {start + seconds:g} s"


def _draw(
    filming: FilmRecorder | None, tracks: RecordingSummary, name: str, request: PeopleRequest
) -> None:
    if filming is None:
        return
    with waiting("drawing"):
        if request.plot is not None:
            filming.draw(tracks, request.plot, name)
        if request.animate is not None:
            filming.animate(tracks, request.animate, name, request.speed_up)


def _print(
    recording: SensorRecording,
    tracks: RecordingSummary,
    begin: float,
    scores: LabelScores | None,
    request: PeopleRequest,
) -> None:
    if request.json:
        if scores is not None:
            write_json({"scores": scores_json(scores)})
    else:
        tables = {recording.name: facts_table(tracks, begin)}
        if tracks.trails:
            tables[people_title(tracks)] = people_table(tracks, begin)
        if scores is not None:
            tables["scores against the labels"] = scores_table(scores)
        for title, table in tables.items():
            OUTPUT.print(Text(title, style="bold"), soft_wrap=True)
            OUTPUT.print(table)
        for file in (request.plot, request.animate):
            if file is not None:
                print_line(f"written: {file}")
    for warning in recording.warnings:
        streams.say(f"warning: {warning}")
    for warning, count in tracks.warnings.items():
        streams.say(f"warning: {request.recording}: {warning}; {count} of {tracks.frames} frames")


def _warn(request: PeopleRequest, scores: LabelScores | None, filming: FilmRecorder | None) -> None:
    """Warn where the result is probably not what was intended."""
    if scores is not None and not scores.instants:
        streams.say(f"warning: {request.truth}: has no labels at the times of the recording")
    elif scores is not None and scores.labels and not scores.found:
        streams.say(
            f"warning: {request.truth}: no person was tracked near a label: do the labels belong "
            f"to {request.recording}?"
        )
    if filming is not None and request.at is not None and abs(filming.at - request.at) > AWAY:
        streams.say(f"warning: --at {request.at:g}: the nearest reading is at {filming.at:.1f} s")
