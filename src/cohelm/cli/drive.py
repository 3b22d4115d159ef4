"""``cohelm drive``: prepare a live ride, then serve its page."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from cohelm import plugins
from cohelm.arrays import replace, value
from cohelm.cli import parsing, platform_file
from cohelm.cli.requests import DriveRequest, RunRequest
from cohelm.cli.scenario_request import check_record, scenario_of
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.live import DriveSetup, DriveStorey, NextStorey
from cohelm.live.messages import Limits
from cohelm.live.sessions.records import default_folder
from cohelm.maps import distance_field, places_beside, read_map
from cohelm.planning.free_space import check_free_space
from cohelm.scenarios import Scenario
from cohelm.scenarios.objects import Mask
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

        def on_storey(storey: NextStorey) -> DriveSetup:
            x, y, heading = storey.pose
            start = f"{x:.6f},{y:.6f},{math.degrees(heading):.6f}"
            there = drive_setup(replace(request, start=start), files, storey=storey.name)
            return replace(there, mode=storey.mode, pace=storey.pace)

        web_server.serve_ride(setup, page, request, on_storey=on_storey)
    sys.stdout.write("stopped; the page is closed\n")
    return 0


def drive_setup(request: DriveRequest, files: contextlib.ExitStack, storey: str = "") -> DriveSetup:
    """Return the ride of a request.

    Args:
        request: Options.
        files: Removes temporary files when the ride is over.
        storey: Storey of a building; empty: that of the start, else the lowest.

    Raises:
        CohelmError: naming the option, the key or the file.
    """
    name = request.platform
    if name is not None and name.endswith((".yaml", ".yml")):
        file = Path(name)
        return drive_setup_of(platform_file.read(file), file, request, files)
    building = None
    if request.map is not None and Path(request.map).is_dir():
        building = drive_building(Path(request.map))
        there, start = building.start_of(request.start)
        storey = storey or there
        request = replace(request, map=str(building.maps[storey]), start=start)
    scenario = scenario_of_drive(request)
    if (
        building is not None
        and (slow := building.maps[storey].with_suffix(".speed.yaml")).is_file()
    ):
        near_doors = Mask(type="speed_percent", file=str(slow.resolve()))
        scenario = scenario.model_copy(update={"filters": (*scenario.filters, near_doors)})
    if name is not None:
        plugins.load("platforms", name)
        scenario = scenario.model_copy(update={"platform": {"use": name}})
    setup = _setup(scenario, None, request)
    if building is None:
        return setup
    return replace(setup, storey=storey, storeys=building.storeys)


def drive_setup_of(
    given: platform_file.PlatformFile,
    file: Path,
    request: DriveRequest,
    files: contextlib.ExitStack,
) -> DriveSetup:
    """Return the ride of a real chair, from the content of its file; see :func:`drive_setup`."""
    scenario, limits = platform_file.ride_of(given, file, request, files)
    return _setup(scenario, limits, request)


@value
class DriveBuilding:
    """Storeys of a building with a map, lowest first."""

    storeys: tuple[DriveStorey, ...]
    maps: Mapping[str, Path]
    """Map files by the storey's name."""
    numbers: Mapping[str, str]
    """Names of the storeys by their number."""

    def start_of(self, start: str | None) -> tuple[str, str | None]:
        """Name of the storey of a start, and the start there.

        ``PLACE @ STOREY`` names it, or gives its number; else the first one with that place, or the
        lowest.

        Raises:
            ConfigError: if there is no such storey.
        """
        text = start or ""
        named = [s.name for s in self.storeys if text.casefold() in map(str.casefold, s.places)]
        place, _, where = (part.strip() for part in text.rpartition("@"))
        if named or not place:
            return (named or [self.storeys[0].name])[0], start
        known = {**{name.casefold(): name for name in self.maps}, **self.numbers}
        if where.casefold() not in known:
            raise ConfigError(f"no storey {where!r}{nearest(where, self.maps)}", key="--start")
        return known[where.casefold()], place


def drive_building(folder: Path) -> DriveBuilding:
    """Read the storeys that ``cohelm building --out`` wrote to a folder.

    Raises:
        CohelmError: if the folder has no storey with a map, or a file cannot be read.
    """
    from cohelm.buildings import lifts_of, read_storeys, room_names  # an extra

    written = read_storeys(folder)
    files = {each.number: folder / f"{each.stem}.yaml" for each in written}
    storeys = [each for each in written if files[each.number].is_file()]
    if not storeys:
        raise ConfigError(f"{folder}: no storey there has a map", key="--map")
    same = Counter(each.name for each in storeys)
    names = {s.number: s.name if same[s.name] == 1 else f"{s.name} ({s.number})" for s in storeys}
    found, joined = [], lifts_of(written)
    for storey in storeys:
        rooms, lifts = room_names(storey.rooms), {}
        for lift in joined:
            landings = {each.storey: each for each in lift.landings}
            if storey.number in landings:
                place = rooms.get(landings[storey.number].room, lift.name)
                others = (k for k in names if k in landings and k != storey.number)
                lifts[place] = tuple(names[k] for k in others)
        name, places = names[storey.number], tuple(each.name for each in storey.places)
        found.append(DriveStorey(name=name, grid=storey.grid, places=places, lifts=lifts))
    maps = {name: files[number] for number, name in names.items()}
    numbers = {str(number): name for number, name in names.items()}
    return DriveBuilding(storeys=tuple(found), maps=maps, numbers=numbers)


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
