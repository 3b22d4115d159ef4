"""``cohelm propose``, ``choose`` and ``preferences``: routes to choose from, and habits."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cohelm.cli import compiled_code, options

app = typer.Typer()

preferences = typer.Typer(
    name="preferences",
    help="What was learned from a rider's choices: show it, or forget it.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)
app.add_typer(preferences)

_RIDER = "Whose choices to go by: a name, or a .json file of one's own."
Rider = Annotated[str, typer.Option(metavar="NAME|FILE", help=_RIDER)]


@app.command()
def propose(  # noqa: PLR0913, PLR0917 # an option is an argument
    map_: options.MapFile,
    start: options.Start,
    goal: options.Goal,
    prefer: options.Prefer = None,
    ordered: options.Ordered = False,
    avoid: options.Avoid = None,
    avoid_hard: options.AvoidHard = None,
    stroke: options.Stroke = None,
    alternatives: options.Alternatives = 3,
    rider: Annotated[str | None, typer.Option(metavar="NAME|FILE", help=_RIDER)] = None,
    take: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Note at once that the rider takes route N."),
    ] = None,
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
        Path | None, typer.Option(metavar="FILE", help="A picture of all routes, numbered.")
    ] = None,
) -> int:
    """Propose routes to choose from, ranked by what the rider chose before, and say why.

    Nothing is chosen for the rider: say afterwards which route was taken with 'cohelm choose'.
    """
    compiled_code.place()
    from cohelm.cli import plan, wishes  # noqa: PLC0415 # lazy
    from cohelm.cli import propose as command  # noqa: PLC0415 # lazy

    asked = plan.Asked(
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
    return command.propose(asked, rider, take, json=json, plot=plot)


@app.command()
def choose(
    taken: Annotated[
        int, typer.Argument(metavar="N", min=1, help="Number of the route, as it was shown.")
    ],
    rider: Rider,
) -> int:
    """Note which of the routes proposed last the rider has taken, and learn from it."""
    compiled_code.place()
    from cohelm.cli import propose as command  # noqa: PLC0415 # lazy

    return command.choose(taken, rider)


@preferences.command()
def show(rider: Rider, json: options.Json = False) -> int:
    """Show what was learned from a rider's choices."""
    compiled_code.place()
    from cohelm.cli import propose as command  # noqa: PLC0415 # lazy

    return command.show(rider, json=json)


@preferences.command()
def reset(rider: Rider) -> int:
    """Forget a rider's choices and what was learned from them; the file is kept as .bak."""
    compiled_code.place()
    from cohelm.cli import propose as command  # noqa: PLC0415 # lazy

    return command.reset(rider)
