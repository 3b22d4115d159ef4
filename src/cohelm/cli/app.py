"""The commands and their options, and how any failure becomes one line and an exit status.

Exit status: 0 the goal was reached or the command did its work, 1 the ride failed, 2 bad input.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from cohelm.cli import (
    benches,
    choosing,
    compiled_code,
    listing,
    live,
    options,
    recorded,
    results,
    streams,
)
from cohelm.errors import CohelmError

FAILED, BAD_INPUT = 1, 2
INTERRUPTED = 130
"""128 + the number of the signal, as shells have it."""

app = typer.Typer(
    name="cohelm",
    help="Shared control for wheelchairs among people: the rider and the chair steer together.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

app.add_typer(live.app)
app.add_typer(recorded.app)
app.add_typer(choosing.app)
app.add_typer(benches.app)
app.add_typer(listing.app)
app.add_typer(results.app)

_USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[2]  # ClickException, whoever ships it


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and leave with its exit status."""
    streams.prepare()
    sys.exit(status(sys.argv[1:] if arguments is None else arguments))


def status(arguments: Sequence[str]) -> int:
    """Run one command; returns the exit status."""
    warnings.showwarning = _warn
    try:
        result = app(args=list(arguments), prog_name="cohelm", standalone_mode=False)
        sys.stdout.flush()
    except typer.Exit as leave:
        return leave.exit_code
    except typer.Abort:
        result = INTERRUPTED
    except _USAGE_ERROR as error:
        text = error.format_message() if hasattr(error, "format_message") else str(error)
        return _refuse(text or "no command given; see cohelm --help")
    except CohelmError as error:
        return _refuse(str(error))
    except (OSError, MemoryError, KeyboardInterrupt) as error:
        return _stopped(error)
    if result == INTERRUPTED:  # what typer makes of an interrupt
        return _stopped(KeyboardInterrupt())
    return result if isinstance(result, int) else 0


def _stopped(error: BaseException) -> int:
    """The exit status where something around the command ended it."""
    if isinstance(error, KeyboardInterrupt):
        streams.say("interrupted")
        return INTERRUPTED
    if isinstance(error, MemoryError):
        return _refuse("not enough memory; take a smaller map")
    streams.drop_output()
    if isinstance(error, BrokenPipeError):  # as head does to those who write to it
        return streams.NOBODY_READS
    what = f"cannot be read or written ({getattr(error, 'strerror', None) or error})"
    return _refuse(f"{getattr(error, 'filename', None) or 'output or working folder'}: {what}")


def _warn(message: Warning | str, *where: Any, **options: Any) -> None:
    streams.say(f"warning: {message}")


def _refuse(text: str) -> int:
    streams.say(f"error: {text}")
    return BAD_INPUT


def _show_version(wanted: bool) -> None:  # typer calls it so
    if wanted:
        from importlib.metadata import version  # noqa: PLC0415 # lazy

        sys.stdout.write(f"cohelm {version('cohelm')}\n")
        sys.stdout.flush()
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    pass


@app.command(context_settings={"ignore_unknown_options": False})
def run(  # noqa: PLR0913, PLR0917 # an option is an argument
    scenario: options.Scenario = "hospital",
    map_: Annotated[
        str | None, typer.Option("--map", metavar="FILE.yaml", help="Ride on a map of your own.")
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y[,DEG]|NAME", help="In metres and degrees on the map, or a place."
        ),
    ] = None,
    goal: Annotated[
        str | None, typer.Option(metavar="X,Y|NAME", help="Where the ride shall end.")
    ] = None,
    prefer: options.Prefer = None,
    people: options.People = None,
    planner: Annotated[str | None, typer.Option(metavar="NAME", help="Local planner.")] = None,
    method: Annotated[str | None, typer.Option(metavar="NAME", help="Global planner.")] = None,
    robot: options.Chair = None,
    rider: Annotated[str | None, typer.Option(metavar="NAME", help="Simulated rider.")] = None,
    mode: Annotated[
        str | None, typer.Option(metavar="autonomous|shared|assisted|manual", help="Who steers.")
    ] = None,
    seed: options.Seed = None,
    set_: options.ScenarioSettings = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write ride.json, ride.png, track.csv.")
    ] = None,
    json: options.Json = False,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="A picture.")] = None,
    animate: Annotated[
        Path | None, typer.Option(metavar="FILE.gif|mp4", help="A moving picture.")
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(metavar="FILE.mcap", help="Record the ride, for viewers and cohelm replay."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")] = False,
) -> int:
    """Ride a scenario, and say how it went."""
    compiled_code.place()
    from cohelm.cli import run as command  # noqa: PLC0415 # lazy

    asked = command.Asked(
        scenario=scenario,
        map=map_,
        start=start,
        goal=goal,
        prefer=tuple(prefer or ()),
        people=people,
        planner=planner,
        method=method,
        robot=robot,
        rider=rider,
        mode=mode,
        seed=seed,
        settings=tuple(set_ or ()),
    )
    outputs = command.Outputs(
        out=out, json=json, plot=plot, animate=animate, record=record, quiet=quiet
    )
    return command.run(asked, outputs)


@app.command()
def plan(  # noqa: PLR0913, PLR0917 # an option is an argument
    map_: options.MapFile,
    start: options.Start,
    goal: options.Goal,
    prefer: options.Prefer = None,
    ordered: options.Ordered = False,
    avoid: options.Avoid = None,
    avoid_hard: options.AvoidHard = None,
    stroke: options.Stroke = None,
    alternatives: options.Alternatives = 1,
    method: options.Method = options.METHOD,
    set_: options.Settings = None,
    robot: options.Robot = options.ROBOT,
    clearance: options.Clearance = 0.0,
    speed: options.Speed = options.SPEED,
    keepout: options.Keepout = None,
    speed_mask: options.SpeedMask = None,
    crowding: options.Crowding = None,
    json: options.Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A picture; its folder is made where there is none."),
    ] = None,
) -> int:
    """Plan a route on a map, and say what a wish costs."""
    compiled_code.place()
    from cohelm.cli import plan as command  # noqa: PLC0415 # lazy
    from cohelm.cli import wishes  # noqa: PLC0415 # lazy

    asked = command.Asked(
        map=map_,
        start=start,
        goal=goal,
        wishes=wishes.Asked(
            prefer=tuple(prefer or ()),
            ordered=ordered,
            avoid=tuple(avoid or ()),
            avoid_hard=tuple(avoid_hard or ()),
            stroke=tuple(stroke or ()),
        ),
        method=method,
        settings=tuple(set_ or ()),
        robot=robot,
        clearance=clearance,
        speed=speed,
        alternatives=alternatives,
        keepout=tuple(keepout or ()),
        speed_mask=tuple(speed_mask or ()),
        crowding=crowding,
    )
    return command.plan(asked, json=json, plot=plot)
