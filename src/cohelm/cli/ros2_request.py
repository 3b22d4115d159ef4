"""Options of ``cohelm ros2``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass(frozen=True, kw_only=True)
class Ros2Request:
    """Options of ``cohelm ros2``."""

    file: Annotated[
        Path, typer.Argument(metavar="ROBOT.yaml", help="Robot: topics, frames, map, limits.")
    ]
    check: Annotated[
        bool, typer.Option("--check", help="Say what is missing or wrong; nothing moves.")
    ] = False
    move: Annotated[
        bool,
        typer.Option("--move", help="With --check: drive 0.2 m forward, once you have agreed."),
    ] = False
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png", help="With --check: draw map, pose and scans."),
    ] = None
    transport: Annotated[
        str | None,
        typer.Option(
            metavar="dds|rclpy", help="Without ROS, or on a ROS installation; default: the file's."
        ),
    ] = None
    host: Annotated[str, typer.Option(metavar="NAME|ADDRESS", help="As for 'cohelm drive'.")] = (
        "127.0.0.1"
    )
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any free port.")] = 8000
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.mcap", help="Record everything, for viewers.")
    ] = None
    viewer: Annotated[
        tuple[str, ...], typer.Option(metavar="ORIGIN", help="As for 'cohelm drive'.")
    ] = ()
    data: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of sessions, limits and log.")
    ] = None
