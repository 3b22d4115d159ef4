"""``cohelm drive``: prepare a live ride, then serve its page."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import sys
from pathlib import Path

import numpy as np

from cohelm import plugins
from cohelm.cli import parsing, platform_file
from cohelm.cli.requests import DriveRequest, RunRequest
from cohelm.cli.scenario_request import check_record, scenario_of
from cohelm.errors import ConfigError
from cohelm.live import DriveSetup
from cohelm.live.messages import Limits
from cohelm.live.sessions.records import default_folder
from cohelm.maps import distance_field, places_beside, read_map
from cohelm.planning.free_space import check_free_space
from cohelm.scenarios import Scenario
from cohelm.scenarios.scenario import robot_of

EXTRA = ("fastapi", "uvicorn", "websockets", "cryptography", "qrcode")
"""Packages of the extra ``web``."""


def drive(request: DriveRequest) -> int:
    """Serve until interrupted; returns 0.

    Raises:
        CohelmError: if an option, a file or the scenario is at fault.
    """
    check_installed()
    from cohelm.cli import web_server

    page = web_server.read_page()
    if request.replay is not None:
        web_server.show_recording(request.replay, page, request)
        return 0
    if (request.cert is None) != (request.key is None):
        raise ConfigError("--cert and --key belong together", key="--cert")
    if request.record is not None:
        check_record(request.record)
    with contextlib.ExitStack() as files:
        setup = drive_setup(request, files)
        web_server.serve_ride(setup, page, request)
    sys.stdout.write("stopped; the page is closed\n")
    return 0


def drive_setup(request: DriveRequest, files: contextlib.ExitStack) -> DriveSetup:
    """Return the ride of a request.

    Args:
        request: Options.
        files: Removes temporary files when the ride is over.

    Raises:
        CohelmError: naming the option, the key or the file.
    """
    name = request.platform
    if name is not None and name.endswith((".yaml", ".yml")):
        file = Path(name)
        return drive_setup_of(platform_file.read(file), file, request, files)
    scenario = scenario_of_drive(request)
    if name is not None:
        plugins.load("platforms", name)
        scenario = scenario.model_copy(update={"platform": {"use": name}})
    return _setup(scenario, None, request)


def drive_setup_of(
    given: platform_file.PlatformFile,
    file: Path,
    request: DriveRequest,
    files: contextlib.ExitStack,
) -> DriveSetup:
    """Return the ride of a real chair, from the content of its file; see :func:`drive_setup`."""
    scenario, limits = platform_file.ride_of(given, file, request, files)
    return _setup(scenario, limits, request)


def _setup(scenario: Scenario, limits: Limits | None, request: DriveRequest) -> DriveSetup:
    return DriveSetup(
        scenario=scenario,
        seed=scenario.seed if request.seed is None else request.seed,
        folder=request.data or default_folder(),
        record=request.record,
        limits=limits,
    )


def check_installed() -> None:
    """Refuse where the extra ``web`` is not installed.

    Raises:
        ConfigError: saying how to install it.
    """
    missing = [name for name in EXTRA if importlib.util.find_spec(name) is None]
    if missing:
        problem = f"needs the extra 'web' ({', '.join(missing)} missing)"
        raise ConfigError(f"{problem}: pip install 'cohelm[web]'", key="cohelm drive")


def scenario_of_drive(request: DriveRequest) -> Scenario:
    """Load the scenario and apply the options; the rider chooses the destination later.

    Raises:
        CohelmError: naming the option, the key or the file.
    """
    start, goal = request.start, None
    if request.map is not None:
        start = start or _default_start(request.map)
        spot = parsing.place(start, "--start", heading=True)
        goal = spot if isinstance(spot, str) else f"{spot[0]},{spot[1]}"
    scenario = scenario_of(
        RunRequest(
            scenario=request.scenario,
            map=request.map,
            start=start,
            goal=goal,
            people=request.people,
            robot=request.robot,
            settings=request.settings,
        )
    )
    if request.map is None or start is None:
        return scenario
    name = f"{scenario.name} on {Path(request.map).stem}"
    goal_point = _first_goal(request.map, start, scenario)
    return scenario.model_copy(update={"name": name, "goal": goal_point})


def _default_start(map_: str) -> str:
    """The first place of a map, or the point with the largest clearance if it names none."""
    places = places_beside(map_)
    if places.names:
        return str(places.names[0])
    grid = read_map(map_)
    clearance = distance_field(grid).distance
    cell = np.unravel_index(int(np.argmax(clearance)), clearance.shape)
    x, y = grid.centres(np.array(cell))
    return f"{x:.2f},{y:.2f}"


def _first_goal(map_: str, start: str, scenario: Scenario) -> tuple[float, float]:
    """Goal until the rider chooses one: the start, or the nearest point with room for a goal.

    Raises:
        ConfigError: if the chair does not fit at the start; it names that nearest point.
    """
    spot = parsing.place(start, "--start", heading=True)
    grid = read_map(map_)
    x, y = places_beside(map_).find(spot).point if isinstance(spot, str) else spot[:2]
    heading = math.radians(spot[2]) if not isinstance(spot, str) and len(spot) == 3 else None
    check = check_free_space(
        grid,
        robot_of(scenario),
        (float(x), float(y)),
        heading,
        clearance=scenario.profile.clearance,
    )
    if check.fits and check.nearest is not None:
        return check.nearest
    free = "nowhere on this map" if check.nearest is None else "nearest free point {:.2f},{:.2f}"
    where = free.format(*(check.nearest or ()))
    raise ConfigError(f"the chair does not fit at {x:.2f},{y:.2f}; {where}", key="--start")
