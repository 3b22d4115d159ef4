"""``cohelm drive``: its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cohelm.cli import compiled_code, options

app = typer.Typer()


@app.command()
def drive(  # noqa: PLR0913, PLR0917 # an option is an argument
    scenario: options.Scenario = "hospital",
    map_: Annotated[
        str | None, typer.Option("--map", metavar="FILE.yaml", help="Drive on a map of your own.")
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y[,DEG]|NAME",
            help="Where the chair stands; unset on a map of your own: where there is most room.",
        ),
    ] = None,
    people: options.People = None,
    robot: options.Chair = None,
    seed: options.Seed = None,
    set_: options.ScenarioSettings = None,
    host: Annotated[
        str,
        typer.Option(
            metavar="NAME|ADDRESS",
            help="To listen on; 0.0.0.0 is every one of this machine. Where others can reach it, "
            "it takes a token and TLS.",
        ),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any that is free.")] = 8000,
    cert: Annotated[
        Path | None,
        typer.Option(metavar="FILE.pem", help="A certificate; unset, one is made where needed."),
    ] = None,
    key: Annotated[Path | None, typer.Option(metavar="FILE.pem", help="Its key.")] = None,
    record: Annotated[
        Path | None,
        typer.Option(metavar="FILE.mcap", help="Record all of it, for viewers."),
    ] = None,
    data: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Keeps sessions, limits and the log; unset, in your data folder."
        ),
    ] = None,
    open_: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
) -> int:
    """Drive the chair in a browser; ends with Ctrl-C."""
    compiled_code.place()
    from cohelm.cli import drive as command  # noqa: PLC0415 # lazy

    asked = command.Asked(
        scenario=scenario,
        map=map_,
        start=start,
        people=people,
        robot=robot,
        seed=seed,
        settings=tuple(set_ or ()),
        host=host,
        port=port,
        cert=cert,
        key=key,
        record=record,
        data=data,
        open=open_,
    )
    return command.drive(asked)
