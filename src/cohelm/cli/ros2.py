"""``cohelm ros2``: drive a ROS 2 robot, or check what it sends before anything moves."""

from __future__ import annotations

import contextlib
import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from cohelm.cli import drive, platform_file
from cohelm.cli.report import print_line
from cohelm.cli.requests import DriveRequest
from cohelm.cli.ros2_request import Ros2Request
from cohelm.config import load, validate
from cohelm.errors import ConfigError
from cohelm.maps import write_map

if TYPE_CHECKING:
    from cohelm.live import Drive
    from cohelm.ros2.findings import CheckFinding
    from cohelm.ros2.parameters import Ros2Parameters

WATCH = 5.0
"""Time for which the check watches the topics, s."""


def ros2(request: Ros2Request) -> int:
    """Drive until interrupted, or check; returns 0, or 1 where the check found a fault.

    Raises:
        CohelmError: if the file is at fault, or the robot does not answer.
    """
    given = load(platform_file.PlatformFile, request.file)
    if given.platform.get("use") != "ros2":
        raise ConfigError("write 'use: ros2'", file=request.file, key="platform.use")
    from cohelm.ros2.parameters import Ros2Parameters

    if request.transport is not None:
        given = given.model_copy(
            update={"platform": {**given.platform, "transport": request.transport}}
        )
    data = {key: each for key, each in given.platform.items() if key != "use"}
    parameters = validate(Ros2Parameters, data, file=request.file, prefix="platform")
    if parameters.people is not None:
        given = given.model_copy(update={"scenario": {"tracker": "given", **given.scenario}})
    if parameters.transport == "dds" and importlib.util.find_spec("cyclonedds") is None:
        raise ConfigError(
            "needs the extra 'ros2': pip install 'cohelm[ros2,web]'", key="cohelm ros2"
        )
    with contextlib.ExitStack() as files:
        if request.check:
            return check(request, given, parameters, files)
        if parameters.map is not None:
            given = _with_map(given, parameters, files)
        return _drive(request, given, parameters, files)


def check(
    request: Ros2Request,
    given: platform_file.PlatformFile,
    parameters: Ros2Parameters,
    files: contextlib.ExitStack,
) -> int:
    """Watch the topics for five seconds, and print what is missing or wrong."""
    from cohelm.ros2 import checking

    has_map = given.map is not None
    if parameters.map is not None:
        print_line(f"waiting for {parameters.map}, at most {parameters.wait:g} s")
        with contextlib.suppress(ConfigError):  # the findings say that it is missing
            given, has_map = _with_map(given, parameters, files), True
    setup = drive.drive_setup_of(given, request.file, _as_drive(request), files)
    print_line(f"watching for {WATCH:g} s; nothing moves")
    report = checking.check(parameters, setup.scenario, watch=WATCH, has_map=has_map)
    findings = list(report.findings)
    if request.move and all(each.fine for each in findings):
        answer = input("The chair will drive 0.2 m forward. Type 'yes' if its way is free: ")
        if answer.strip() == "yes":
            findings.append(checking.move(parameters))
    _print(findings)
    if request.plot is not None:
        checking.draw(report, request.plot)
        print_line(f"drawn in {request.plot}")
    faults = sum(not each.fine for each in findings)
    print_line("ready to drive" if not faults else f"{faults} fault{'s' * (faults > 1)}; see above")
    return 0 if not faults else 1


def _with_map(
    given: platform_file.PlatformFile, parameters: Ros2Parameters, files: contextlib.ExitStack
) -> platform_file.PlatformFile:
    """Return the file's content with the map that a topic brings."""
    from cohelm.ros2 import checking

    grid = checking.take_map(parameters)
    if grid is None:
        raise ConfigError(
            f"no map on {parameters.map} within {parameters.wait:g} s: start the map server, or "
            "name a file with 'map:'",
            key="platform.map",
        )
    folder = Path(files.enter_context(platform_file.folder()))
    write_map(grid, folder / "map.yaml")
    return given.model_copy(update={"map": str(folder / "map.yaml")})


def _drive(
    request: Ros2Request,
    given: platform_file.PlatformFile,
    parameters: Ros2Parameters,
    files: contextlib.ExitStack,
) -> int:
    drive.check_installed()
    from cohelm.cli import web_server
    from cohelm.ros2.rider_node import RiderNode

    page, driving = web_server.read_page(), _as_drive(request)
    setup = drive.drive_setup_of(given, request.file, driving, files)

    def attach(ride: Drive) -> Callable[[], None]:
        return RiderNode(parameters, ride, setup.scenario).close

    web_server.serve_ride(setup, page, driving, attach)
    sys.stdout.write("stopped; the page is closed\n")
    return 0


def _as_drive(request: Ros2Request) -> DriveRequest:
    return DriveRequest(
        host=request.host,
        port=request.port,
        record=request.record,
        data=request.data,
        viewer=request.viewer,
    )


def _print(findings: list[CheckFinding]) -> None:
    for each in findings:
        print_line(f"{'ok   ' if each.fine else 'FAULT'}  {each.what}: {each.text}")
        if each.remedy:
            print_line(f"         → {each.remedy}")
