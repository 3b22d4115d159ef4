"""The options that several commands share: each has one name, one form and one sentence of help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

ROBOT = "quantum_q6_edge"
METHOD = "soft_via"
SPEED = 0.8
"""m/s."""

Scenario = Annotated[str, typer.Argument(help="A name or a .yaml file.")]
People = Annotated[int | None, typer.Option(min=0, max=300, help="How many walk there.")]
Chair = Annotated[str | None, typer.Option(metavar="NAME|FILE", help="The chair.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Of all that is left to chance.")]
ScenarioSettings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Any key of the scenario, dotted: people.see_robot=false.",
    ),
]
MapFile = Annotated[str, typer.Argument(metavar="MAP.yaml", help="Nav2 map_server YAML.")]
Start = Annotated[str, typer.Option(metavar="X,Y|NAME", help="In metres on the map, or a place.")]
Goal = Annotated[str, typer.Option(metavar="X,Y|NAME", help="Where the route shall end.")]
Prefer = Annotated[
    list[str] | None,
    typer.Option(metavar="X,Y", help="A point that attracts the route; may be given again."),
]
Ordered = Annotated[
    bool, typer.Option("--ordered", help="Pass the --prefer points in the order given.")
]
Stroke = Annotated[
    list[Path] | None,
    typer.Option(metavar="FILE", help="Follow a drawn line: lines of x,y, JSON or GeoJSON."),
]
Avoid = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ZONE",
        help="Rather keep out of a zone: 'X,Y[,RADIUS]', a line 'X,Y X,Y[,RADIUS]' (0.5 m where no "
        "radius is given), or an outline 'X,Y X,Y X,Y …'; may be given again.",
    ),
]
AvoidHard = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ZONE", help="Never enter a zone, written as for --avoid, even if no way is left."
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Any parameter of the planner, dotted: inflation.inflation_radius=0.8.",
    ),
]
Clearance = Annotated[
    float, typer.Option(min=0.0, max=10.0, help="To keep beyond the footprint, metres.")
]
Keepout = Annotated[
    list[Path] | None,
    typer.Option(metavar="MASK.yaml", help="Where not to go: a Nav2 keepout mask."),
]
SpeedMask = Annotated[
    list[Path] | None,
    typer.Option(metavar="MASK.yaml", help="Speed limits, percent: a Nav2 speed mask."),
]
Crowding = Annotated[
    Path | None, typer.Option(metavar="FILE.yaml", help="Where people are: a heat map.")
]
Alternatives = Annotated[
    int, typer.Option(metavar="K", min=1, max=20, help="Routes that really differ, at most.")
]
Method = Annotated[str, typer.Option(metavar="NAME", help="Global planner.")]
Robot = Annotated[str, typer.Option(metavar="NAME|FILE", help="The chair.")]
Speed = Annotated[
    float, typer.Option(min=0.1, max=3.0, help="Preferred speed, for the estimated time, m/s.")
]
Json = Annotated[bool, typer.Option("--json", help="Exactly one JSON object on standard output.")]
