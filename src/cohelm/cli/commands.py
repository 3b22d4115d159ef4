"""All commands but the benchmarks; each imports its work when it is called, so starting is fast."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from cohelm.cli.options import Options, command
from cohelm.cli.requests import (
    BuildingRequest,
    DriveRequest,
    GroundRequest,
    Json,
    MapRequest,
    PeopleRequest,
    ReplayRequest,
    RouteRequest,
    RunRequest,
)
from cohelm.cli.ros2_request import Ros2Request

_Request = TypeVar("_Request")


def takes(kind: type[_Request]) -> Callable[[Callable[[_Request], int]], Callable[..., int]]:
    """Decorate a command that takes a request: typer sees one option for each of its fields."""
    options = Options(kind)

    def decorate(run: Callable[[_Request], int]) -> Callable[..., int]:
        return command(
            lambda **given: run(kind(**options.values(given))),
            options.parameters,
            run.__name__,
            run.__doc__ or "",
        )

    return decorate


app = typer.Typer()

map_changes = typer.Typer(
    name="map-changes",
    help="Show where buildings differ from their maps, and write updated copies of maps.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

DataFolder = Annotated[
    Path | None,
    typer.Option("--data", metavar="DIR", help="Folder of the sessions; default: the usual one."),
]
Drawings = Annotated[
    Path | None, typer.Option("--plot", metavar="DIR", help="Draw each of them to this folder.")
]


@app.command()
@takes(RunRequest)
def run(request: RunRequest) -> int:
    """Simulate a ride and print how it went."""
    from cohelm.cli import run

    return run.run(request)


@app.command()
@takes(RouteRequest)
def plan(request: RouteRequest) -> int:
    """Plan a route on a map and print the cost of each wish."""
    from cohelm.cli import plan

    return plan.plan(request)


@app.command("map")
@takes(MapRequest)
def map_(request: MapRequest) -> int:
    """Print size and places of a map, and check that the chair fits at a point."""
    from cohelm.cli import map_info

    return map_info.describe_map(request)


@app.command()
@takes(BuildingRequest)
def building(request: BuildingRequest) -> int:
    """Make maps with rooms and doors from a building's IFC model, or find them in a map."""
    from cohelm.cli import building

    return building.building(request)


@app.command()
@takes(DriveRequest)
def drive(request: DriveRequest) -> int:
    """Drive the chair in a browser; end with Ctrl-C."""
    from cohelm.cli import drive

    return drive.drive(request)


@app.command()
@takes(Ros2Request)
def ros2(request: Ros2Request) -> int:
    """Drive a ROS 2 robot in a browser; needs no ROS; --check tells what is missing."""
    from cohelm.cli import ros2

    return ros2.ros2(request)


@app.command()
@takes(ReplayRequest)
def replay(request: ReplayRequest) -> int:
    """Run the navigator again on a recorded ride and print where the commands differ."""
    from cohelm.cli import replay

    return replay.replay(request)


@app.command()
@takes(PeopleRequest)
def people(request: PeopleRequest) -> int:
    """Detect and track people in a recording: position, velocity, confidence, groups."""
    from cohelm.cli import people

    return people.people(request)


@app.command()
@takes(GroundRequest)
def ground(request: GroundRequest) -> int:
    """Map the floor in a recording: heights, steps and edges."""
    from cohelm.cli import ground

    return ground.ground(request)


app.add_typer(map_changes)


@map_changes.command("show")
def show_map_changes(data: DataFolder = None, json: Json = False) -> int:
    """Show what rides have found to differ: walls that are gone, obstacles that are new."""
    from cohelm.cli import map_changes

    return map_changes.show(data, json=json)


@map_changes.command("apply")
def apply_map_changes(
    file: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="Map that the rides used.")],
    out: Annotated[Path, typer.Option("--out", metavar="NEW.yaml", help="File of the copy.")],
    data: DataFolder = None,
) -> int:
    """Write a copy of a map with these changes; the map itself stays."""
    from cohelm.cli import map_changes

    return map_changes.apply(file, out, data)


@map_changes.command("forget")
def forget_map_changes(
    key: Annotated[
        str | None, typer.Argument(metavar="KEY", help="Key that show prints; default: all.")
    ] = None,
    data: DataFolder = None,
) -> int:
    """Forget the changes to a map."""
    from cohelm.cli import map_changes

    return map_changes.forget(data, key)


@app.command()
def compare(
    before: Annotated[Path, typer.Argument(metavar="A", help="Result folder: before.")],
    after: Annotated[Path, typer.Argument(metavar="B", help="Result folder: after.")],
    measures: Annotated[
        str | None, typer.Option(metavar="A,B", help="Measures to compare; default: the main ones.")
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="One ride that ends worse is a regression.")
    ] = False,
    json: Json = False,
) -> int:
    """Compare two result folders ride by ride; exit status 1 where B is worse."""
    from cohelm.benchmarks.bench import split_names
    from cohelm.cli import compare

    names = split_names(measures, "--measures") or None
    return compare.compare(before, after, names, strict=strict, json=json)


@app.command("compile")
def compile_(
    *,
    profile: Annotated[
        bool,
        typer.Option(
            "--profile", help="Compile all again, aside, and list what each kernel takes."
        ),
    ] = False,
) -> int:
    """Compile everything that a ride needs now, so that no ride waits for it."""
    if profile:
        from cohelm.cli import compile_profile

        return compile_profile.profile()
    from cohelm.cli import compile_kernels

    return compile_kernels.compile_all()


@app.command()
def scenarios(plot: Drawings = None) -> int:
    """List the scenarios that come with cohelm."""
    from cohelm.cli import listings

    return listings.scenarios(plot)


@app.command()
def robots() -> int:
    """List the wheelchairs that come with cohelm, and their sensors."""
    from cohelm.cli import listings

    return listings.robots()


@app.command()
def plugins() -> int:
    """List the parts that a scenario can name, and their origin."""
    from cohelm.cli import listings

    return listings.plugins()


@app.command()
def data() -> int:
    """List the external data sets of tests and benchmarks, and their sources."""
    from cohelm.cli import listings

    return listings.data()
