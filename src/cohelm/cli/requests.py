"""Options of the commands, each declared once: a field of a request is an option with its help."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer

MapFile = Annotated[str, typer.Argument(metavar="MAP.yaml", help="Map as Nav2 map_server YAML.")]
Scenario = Annotated[str, typer.Argument(help="Name of a scenario, or a .yaml file.")]
OwnMap = Annotated[str | None, typer.Option("--map", metavar="FILE.yaml", help="Own map instead.")]
Robot = Annotated[str | None, typer.Option(metavar="NAME|FILE", help="Wheelchair.")]
People = Annotated[int | None, typer.Option(min=0, max=300, help="Number of pedestrians.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Random seed.")]
ScenarioSettings = Annotated[
    tuple[str, ...],
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Any scenario key, dotted: people.see_robot=false."
    ),
]
Prefer = Annotated[
    tuple[str, ...], typer.Option(metavar="X,Y", help="Point that attracts the route; repeatable.")
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
RidePlatform = Annotated[str | None, typer.Option(metavar="planar|twin", help="Simulation.")]
FilmView = Annotated[str | None, typer.Option(metavar="follow|above|rider", help="3-D --animate.")]
Animate = Annotated[
    Path | None,
    typer.Option(metavar="FILE.gif|mp4", help="Write an animation, in real time; see --speed-up."),
]
SpeedUp = Annotated[
    float, typer.Option(min=0.25, max=20.0, help="Playback speed of --animate; 1 is real time.")
]

Topic = Annotated[
    str | None, typer.Option(metavar="NAME", help="Topic of a bag; default: all sensors.")
]
SweepRate = Annotated[
    float, typer.Option(metavar="HZ", min=0.01, help="Sweeps per second in a folder.")
]
Seconds = Annotated[float | None, typer.Option(metavar="T", min=0.0, help="Duration to read.")]


@dataclass(frozen=True, kw_only=True)
class RunRequest:
    """Options of ``cohelm run``; None: as the scenario has it."""

    scenario: Scenario = "hospital"
    platform: RidePlatform = None
    map: OwnMap = None
    start: Annotated[
        str | None, typer.Option(metavar="X,Y[,DEG]|NAME", help="Start, m and degrees, or a place.")
    ] = None
    goal: Annotated[str | None, typer.Option(metavar="X,Y|NAME", help="Destination.")] = None
    prefer: Prefer = ()
    people: People = None
    planner: Annotated[str | None, typer.Option(metavar="NAME", help="Local planner.")] = None
    method: Annotated[str | None, typer.Option(metavar="NAME", help="Global planner.")] = None
    robot: Robot = None
    rider: Annotated[str | None, typer.Option(metavar="NAME", help="Simulated rider.")] = None
    mode: Annotated[
        str | None,
        typer.Option(metavar="autonomous|shared|assisted|stop_only|manual", help="Mode."),
    ] = None
    seed: Seed = None
    settings: ScenarioSettings = ()
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write ride.json, ride.png, track.csv, socnav3.json."),
    ] = None
    json: Json = False
    all: Annotated[bool, typer.Option("--all", help="Print every measure.")] = False
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw the ride.")] = None
    animate: Animate = None
    speed_up: SpeedUp = 1.0
    view: FilmView = None
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.mcap", help="Record for viewers and cohelm replay.")
    ] = None
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print the outcome only.")] = False


@dataclass(frozen=True, kw_only=True)
class DriveRequest:
    """Options of ``cohelm drive``; None: as the scenario has it, or the default."""

    scenario: Scenario = "hospital"
    platform: Annotated[
        str | None, typer.Option(metavar="FILE.yaml|NAME", help="Chair; default: simulated.")
    ] = None
    map: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.yaml|DIR", help="Own map instead, or a folder of cohelm building --out."
        ),
    ] = None
    start: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y[,DEG]|NAME",
            help="Start; default on your own map: its first place, or the most open point.",
        ),
    ] = None
    people: People = None
    robot: Robot = None
    seed: Seed = None
    settings: ScenarioSettings = ()
    host: Annotated[
        str,
        typer.Option(
            metavar="NAME|ADDRESS",
            help="Address to listen on; 0.0.0.0 is every one of this machine. If others can reach "
            "it, the page needs a token and TLS.",
        ),
    ] = "127.0.0.1"
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any free port.")] = 8000
    cert: Annotated[
        Path | None, typer.Option(metavar="FILE.pem", help="TLS certificate; default: a new one.")
    ] = None
    key: Annotated[
        Path | None, typer.Option(metavar="FILE.pem", help="Key of the certificate.")
    ] = None
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.mcap", help="Record everything, for viewers.")
    ] = None
    replay: Annotated[Path | None, typer.Option(metavar="FILE.mcap", help="Show a ride.")] = None
    viewer: Annotated[
        tuple[str, ...], typer.Option(metavar="ORIGIN", help="Site that may watch at /foxglove.")
    ] = ()
    data: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of sessions, limits, log; default: your own."),
    ] = None
    open: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False


@dataclass(frozen=True, kw_only=True)
class RouteRequest:
    """Options of ``cohelm plan``."""

    map: Annotated[
        str,
        typer.Argument(
            metavar="MAP.yaml|DIR",
            help="Map as Nav2 map_server YAML, or a building: the folder of cohelm building --out.",
        ),
    ]
    start: Annotated[
        str,
        typer.Option(
            metavar="X,Y|NAME",
            help="Start, m, or a place; in a building its name or number, as 'Ward 3 @ Level 2'.",
        ),
    ]
    goal: Annotated[str, typer.Option(metavar="X,Y|NAME", help="Destination.")]
    prefer: Annotated[
        tuple[str, ...],
        typer.Option(
            metavar="X,Y|WORD",
            help="Point that attracts the route; in a building 'wide' or 'level' (no ramps); "
            "repeatable.",
        ),
    ] = ()
    ordered: Annotated[
        bool, typer.Option("--ordered", help="Pass the --prefer points in the given order.")
    ] = False
    avoid: Annotated[
        tuple[str, ...],
        typer.Option(
            metavar="ZONE",
            help="Zone to avoid if possible: 'X,Y[,RADIUS]', a line 'X,Y X,Y[,RADIUS]' (default "
            "radius 0.5 m), an outline 'X,Y X,Y X,Y …', or the name of a room; repeatable.",
        ),
    ] = ()
    avoid_hard: Annotated[
        tuple[str, ...],
        typer.Option(
            metavar="ZONE",
            help="Zone never to enter, written as for --avoid, even if no route is left.",
        ),
    ] = ()
    stroke: Annotated[
        tuple[Path, ...],
        typer.Option(metavar="FILE", help="Drawn line to follow: lines of x,y, JSON or GeoJSON."),
    ] = ()
    alternatives: Annotated[
        int, typer.Option(metavar="K", min=1, max=20, help="Maximum number of different routes.")
    ] = 1
    method: Annotated[str, typer.Option(metavar="NAME", help="Global planner.")] = "soft_via"
    settings: Annotated[
        tuple[str, ...],
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Any parameter of the planner, dotted: inflation.inflation_radius=0.8.",
        ),
    ] = ()
    robot: Annotated[str, typer.Option(metavar="NAME|FILE", help="Wheelchair.")] = "quantum_q6_edge"
    clearance: Annotated[
        float, typer.Option(min=0.0, max=10.0, help="Distance to keep beyond the footprint, m.")
    ] = 0.0
    speed: Annotated[
        float, typer.Option(min=0.1, max=3.0, help="Preferred speed, for the travel time, m/s.")
    ] = 0.8
    keepout: Annotated[
        tuple[Path, ...], typer.Option(metavar="MASK.yaml", help="Nav2 keepout mask.")
    ] = ()
    speed_mask: Annotated[
        tuple[Path, ...],
        typer.Option(metavar="MASK.yaml", help="Nav2 speed mask: the darker, the slower."),
    ] = ()
    speed_base: Annotated[
        float | None,
        typer.Option(metavar="NUMBER", help="Limit at mask value 0; default 100 (%)."),
    ] = None
    speed_multiplier: Annotated[
        float | None,
        typer.Option(metavar="NUMBER", help="Change of the limit per unit; default -1 (%)."),
    ] = None
    filter_info: Annotated[
        tuple[Path, ...],
        typer.Option(
            metavar="FILE.yaml",
            help="Type, base and multiplier of the masks: parameters of Nav2's "
            "costmap_filter_info_server; repeatable.",
        ),
    ] = ()
    crowding: Annotated[
        Path | None, typer.Option(metavar="FILE.yaml", help="Heat map of people.")
    ] = None
    json: Json = False
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the routes.")] = None


@dataclass(frozen=True, kw_only=True)
class MapRequest:
    """Options of ``cohelm map``."""

    map: MapFile
    at: Annotated[
        tuple[str, ...],
        typer.Option(metavar="X,Y[,DEG]|NAME", help="Check that the chair fits here; repeatable."),
    ] = ()
    robot: Annotated[str, typer.Option(metavar="NAME|FILE", help="Wheelchair.")] = "quantum_q6_edge"
    json: Json = False
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the map with a metre grid.")
    ] = None


@dataclass(frozen=True, kw_only=True)
class BuildingRequest:
    """Options of ``cohelm building``."""

    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="IFC, IndoorGML, osmAG, or a Nav2 map's YAML.")
    ]
    storey: Annotated[
        str | None,
        typer.Option(metavar="NAME|N", help="Only this storey; 1 is the lowest. Default: all."),
    ] = None
    resolution: Annotated[
        float,
        typer.Option(
            metavar="M", min=0.01, max=1.0, help="Side of a cell, m; a map keeps its own."
        ),
    ] = 0.05
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write map, places, rooms and doors of each storey."),
    ] = None
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace files in the folder of --out.")
    ] = False
    json: Json = False
    plot: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Draw each storey to this folder.")
    ] = None
    report: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.html", help="Write which rooms the chair reaches, and the barriers."
        ),
    ] = None
    robot: Annotated[str, typer.Option(metavar="NAME|FILE", help="Wheelchair of --report.")] = (
        "quantum_q6_edge"
    )
    entrance: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y|NAME",
            help="Room, door or point where --report begins; 'STOREY: NAME' where several have "
            "that name. Default: the doors that lead outside.",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class ReplayRequest:
    """Options of ``cohelm replay``."""

    recording: Annotated[Path, typer.Argument(help="Ride that cohelm run --record wrote, .mcap.")]
    planner: Annotated[str | None, typer.Option(metavar="NAME", help="Another local planner.")] = (
        None
    )
    settings: Annotated[
        tuple[str, ...],
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Another parameter of the navigator, dotted: local_planner.steps=20.",
        ),
    ] = ()
    tolerance: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="Allowed difference of commands, m/s and rad/s; default 0, or 0.001 if it was "
            "recorded with other versions.",
        ),
    ] = None
    json: Json = False
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Draw both series of commands.")
    ] = None


@dataclass(frozen=True, kw_only=True)
class PeopleRequest:
    """Options of ``cohelm people``."""

    recording: Annotated[
        Path,
        typer.Argument(help="ROS bag, KITTI or nuScenes .bin, .pcd, or a folder of them."),
    ]
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object for each frame.")] = (
        False
    )
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the instant with the most people.")
    ] = None
    at: Annotated[
        float | None,
        typer.Option(metavar="T", min=0.0, help="Draw another instant: T seconds from the start."),
    ] = None
    animate: Animate = None
    speed_up: SpeedUp = 1.0
    truth: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Labels to score against; may be the recording itself."),
    ] = None
    map: Annotated[
        str | None, typer.Option("--map", metavar="FILE.yaml", help="Map of static obstacles.")
    ] = None
    robot: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="Robot whose outline hides returns.")
    ] = None
    topic: Topic = None
    rate: SweepRate = 10.0
    start: Annotated[
        float, typer.Option(metavar="T", min=0.0, help="Begin T seconds from the start.")
    ] = 0.0
    seconds: Seconds = None
    settings: Annotated[
        tuple[str, ...],
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Any parameter of a part: tracker.patience=2."
        ),
    ] = ()
    still: Annotated[
        bool,
        typer.Option(
            "--still",
            help="The sensor does not move, if the recording has no pose; default: estimate it.",
        ),
    ] = False


@dataclass(frozen=True, kw_only=True)
class GroundRequest:
    """Options of ``cohelm ground``."""

    recording: Annotated[
        Path,
        typer.Argument(help="ROS bag with clouds, KITTI or nuScenes .bin, .pcd, or a folder."),
    ]
    json: Json = False
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Save a picture of heights and edges.")
    ] = None
    robot: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Robot whose step limits are used.")
    ] = "quantum_q6_edge_lidar"
    reach: Annotated[
        float, typer.Option(metavar="M", min=1.0, max=20.0, help="Distance up to which it looks.")
    ] = 8.0
    topic: Topic = None
    rate: SweepRate = 10.0
    seconds: Seconds = None


@dataclass(frozen=True, kw_only=True)
class BenchRequest:
    """Options of every benchmark; None: the benchmark's own default."""

    seeds: Annotated[
        int | None,
        typer.Option(min=1, max=10_000, help="Number of seeds; default: that of the benchmark."),
    ] = None
    first: Annotated[int, typer.Option(min=0, max=2**31, help="First seed.")] = 0
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Result folder; default: benches/NAME.")
    ] = None
    workers: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Number of processes; default: that of the benchmark."),
    ] = None
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the sweep in the result folder.")
    ] = False
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Remove the results in the folder first.")
    ] = False
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="local|tcp://…",
            help="Run on Dask: a local cluster of --workers processes, or a scheduler.",
        ),
    ] = None
    json: Json = False
    options: Mapping[str, Any] = field(default_factory=dict)
    """Arguments of the benchmark's ``create``; each is an option of its command."""
