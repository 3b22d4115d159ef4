"""``cohelm ground``: the floor in a recording, its edges and heights, a table and a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict

from rich.text import Text

from cohelm.cli import streams
from cohelm.cli.progress import Counting, waiting
from cohelm.cli.report import OUTPUT, plain_table, print_line, write_json
from cohelm.cli.requests import GroundRequest
from cohelm.errors import RecordingError
from cohelm.evaluation.perception.ground_view import GRID, NearestEdge, RecordedGround
from cohelm.recordings import Frame, SensorRecording, open_recording
from cohelm.robots import load_robot


def ground(request: GroundRequest) -> int:
    """Map the floor of a recording and print what it shows; returns 0.

    Raises:
        CohelmError: if an option is at fault, or no cloud shows a floor.
    """
    if request.plot is not None:
        from cohelm.plotting import check_picture

        check_picture(request.plot)
    robot = load_robot(request.robot)
    recording = open_recording(request.recording, topic=request.topic, rate=request.rate)
    found = RecordedGround(robot, request.reach, only=recording.frames == 1)
    with Counting(recording.name, recording.frames, shown=not request.json) as counting:
        for frame in counting(_until(recording, request.seconds)):
            found.add(frame)
    if found.ground is None:
        problem = (
            "shows no floor to any LiDAR or depth camera: it has no clouds"
            if not found.unlevel
            else "shows no floor: no plane was found 0.15 to 3.5 m below the sensor"
        )
        raise RecordingError(problem, file=request.recording)
    if request.plot is not None:
        from cohelm.plotting import draw_ground

        with waiting("drawing"):
            draw_ground(
                found.ground, GRID.resolution, robot, found.pose, request.plot, recording.name
            )
    edge = found.nearest_edge()
    if request.json:
        nearest = None if edge is None else asdict(edge)
        write_json({"sweeps": found.sweeps, "area": found.areas(), "nearest_edge": nearest})
    else:
        table = plain_table("", "")
        table.add_row("sweeps", str(found.sweeps))
        for name, area in found.areas().items():
            table.add_row(name, f"{area:.1f} m²")
        table.add_row("nearest edge", _edge(edge))
        OUTPUT.print(Text(recording.name, style="bold"), soft_wrap=True)
        OUTPUT.print(table)
        if request.plot is not None:
            print_line(f"written: {request.plot}")
    for warning in recording.warnings:
        streams.say(f"warning: {warning}")
    if found.unlevel:
        streams.say(f"warning: {request.recording}: {found.unlevel} clouds show no floor")
    return 0


def _until(recording: SensorRecording, seconds: float | None) -> Iterator[Frame]:
    """Frames of the first ``seconds`` of the recording."""
    begin = math.nan
    for frame in recording:
        begin = frame.observation.time if math.isnan(begin) else begin
        if seconds is not None and frame.observation.time - begin > seconds:
            return
        yield frame


def _edge(edge: NearestEdge | None) -> str:
    if edge is None:
        return "none"
    return f"{edge.kind}, {edge.distance:.2f} m away at {math.degrees(edge.bearing):.0f}°"
