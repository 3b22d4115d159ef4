"""``cohelm replay`` and ``people``, which read recordings: their options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cohelm.cli import compiled_code, options

app = typer.Typer()


@app.command()
def replay(
    recording: Annotated[
        Path, typer.Argument(help="A ride that cohelm run --record has written, .mcap.")
    ],
    planner: Annotated[
        str | None, typer.Option(metavar="NAME", help="Another local planner.")
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Another parameter of the navigator, dotted: local_planner.steps=20.",
        ),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="What commands may differ by, m/s and rad/s; unset: nothing, or 0.001 where it "
            "was recorded with other versions.",
        ),
    ] = None,
    json: options.Json = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="A picture of both commands.")
    ] = None,
) -> int:
    """Ride a recorded ride again, and say where the commands differ."""
    compiled_code.place()
    from cohelm.cli import replay as command  # noqa: PLC0415 # lazy

    asked = command.Asked(
        file=recording,
        settings=tuple(set_ or ()),
        planner=planner,
        tolerance=tolerance,
        json=json,
        plot=plot,
    )
    return command.replay(asked)


@app.command()
def people(  # noqa: PLR0913, PLR0917 # an option is an argument
    recording: Annotated[
        Path,
        typer.Argument(help="A ROS bag, a KITTI or nuScenes .bin, a .pcd, or a folder of them."),
    ],
    json: Annotated[
        bool, typer.Option("--json", help="One JSON object for each frame on standard output.")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A picture of the busiest instant.")
    ] = None,
    at: Annotated[
        float | None,
        typer.Option(metavar="T", min=0.0, help="Of another instant: T seconds from the start."),
    ] = None,
    animate: Annotated[
        Path | None, typer.Option(metavar="FILE.gif|mp4", help="A moving picture.")
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Labels to score against; the recording's own: again."),
    ] = None,
    map_: Annotated[
        str | None, typer.Option("--map", metavar="FILE.yaml", help="What stands there anyway.")
    ] = None,
    topic: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of a bag; unset, all sensors.")
    ] = None,
    rate: Annotated[
        float, typer.Option(metavar="HZ", min=0.01, help="Of the sweeps in a folder, a second.")
    ] = 10.0,
    start: Annotated[
        float, typer.Option(metavar="T", min=0.0, help="Begin T seconds from the start.")
    ] = 0.0,
    seconds: Annotated[
        float | None, typer.Option(metavar="T", min=0.0, help="How much of it.")
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Any parameter of a part: tracker.patience=2."
        ),
    ] = None,
    still: Annotated[
        bool,
        typer.Option(
            "--still", help="The sensor rests, if the recording does not say; unset, find its way."
        ),
    ] = False,
) -> int:
    """Say who is in a recording: where, how fast, how sure, and who belongs together."""
    compiled_code.place()
    from cohelm.cli import people as command  # noqa: PLC0415 # lazy

    asked = command.Asked(
        recording=recording,
        truth=truth,
        map=map_,
        topic=topic,
        rate=rate,
        start=start,
        seconds=seconds,
        settings=tuple(set_ or ()),
        at_rest=still,
    )
    return command.people(asked, command.Outputs(json=json, plot=plot, at=at, animate=animate))
