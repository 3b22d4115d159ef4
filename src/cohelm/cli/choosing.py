"""``cohelm propose``, ``choose`` and ``preferences``: routes to choose from, and habits."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cohelm.cli import compiled_code

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
Json = Annotated[bool, typer.Option("--json", help="Exactly one JSON object on standard output.")]


@app.command()
def propose(  # noqa: PLR0913, PLR0917 # an option is an argument
    map_: Annotated[str, typer.Argument(metavar="MAP.yaml", help="Nav2 map_server YAML.")],
    start: Annotated[
        str, typer.Option(metavar="X,Y|NAME", help="In metres on the map, or a place.")
    ],
    goal: Annotated[str, typer.Option(metavar="X,Y|NAME", help="Where the routes shall end.")],
    prefer: Annotated[
        list[str] | None,
        typer.Option(metavar="X,Y", help="A point that attracts the route; may be given again."),
    ] = None,
    avoid: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ZONE",
            help="Rather keep out of a zone: 'X,Y,RADIUS', or an outline 'X,Y X,Y X,Y …'; again.",
        ),
    ] = None,
    avoid_hard: Annotated[
        list[str] | None,
        typer.Option(metavar="ZONE", help="Never enter a zone, even if no way is left."),
    ] = None,
    crowding: Annotated[
        Path | None, typer.Option(metavar="FILE.yaml", help="Where people are: a heat map.")
    ] = None,
    alternatives: Annotated[
        int, typer.Option(metavar="K", min=1, max=20, help="Routes to choose from, at most.")
    ] = 3,
    rider: Annotated[str | None, typer.Option(metavar="NAME|FILE", help=_RIDER)] = None,
    take: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Note at once that the rider takes route N."),
    ] = None,
    method: Annotated[str, typer.Option(metavar="NAME", help="Global planner.")] = "soft_via",
    robot: Annotated[str, typer.Option(metavar="NAME|FILE", help="The chair.")] = "quantum_q6_edge",
    speed: Annotated[
        float, typer.Option(min=0.1, max=3.0, help="Preferred speed, for the estimated time, m/s.")
    ] = 0.8,
    json: Json = False,
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
            avoid=tuple(avoid or ()),
            avoid_hard=tuple(avoid_hard or ()),
        ),
        method=method,
        settings=(),
        robot=robot,
        clearance=0.0,
        speed=speed,
        alternatives=alternatives,
        keepout=(),
        speed_mask=(),
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
def show(rider: Rider, json: Json = False) -> int:
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
