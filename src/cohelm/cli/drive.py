"""``cohelm drive``: a live ride behind a server, and where to find it."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm.cli import run as ride
from cohelm.cli import words
from cohelm.driving import DriveSetup
from cohelm.driving.records import default_folder
from cohelm.errors import ConfigError
from cohelm.evaluation import Scenario
from cohelm.maps import distance_field, places_beside, read_map

EXTRA = ("fastapi", "uvicorn", "websockets", "cryptography", "qrcode")
"""What the extra ``web`` brings."""


@dataclass(frozen=True)
class Asked:
    """What the options say; None: what the scenario says, or what is usual."""

    scenario: str
    map: str | None = None
    start: str | None = None
    people: int | None = None
    robot: str | None = None
    seed: int | None = None
    settings: tuple[str, ...] = ()
    host: str = "127.0.0.1"
    port: int = 8000
    cert: Path | None = None
    key: Path | None = None
    record: Path | None = None
    data: Path | None = None
    open: bool = False


def drive(asked: Asked) -> int:
    """Serve until interrupted; returns 0.

    Raises:
        CohelmError: if what was asked cannot be done.
    """
    check_installed()
    from cohelm.cli import door  # noqa: PLC0415 # needs the extra

    page = door.built_page()
    if (asked.cert is None) != (asked.key is None):
        raise ConfigError("--cert and --key belong together", key="--cert")
    if asked.record is not None:
        ride.check_record(asked.record)
    scenario = scenario_of(asked)
    setup = DriveSetup(
        scenario=scenario,
        seed=scenario.seed if asked.seed is None else asked.seed,
        folder=asked.data or default_folder(),
        record=asked.record,
    )
    door.open_door(setup, page, asked)
    sys.stdout.write("the chair stands, and the page is closed\n")
    return 0


def check_installed() -> None:
    """Refuse where the extra is not installed.

    Raises:
        ConfigError: saying how to install it.
    """
    missing = [name for name in EXTRA if importlib.util.find_spec(name) is None]
    if missing:
        what = f"needs the extra 'web' ({', '.join(missing)} missing)"
        raise ConfigError(f"{what}: pip install 'cohelm[web]'", key="cohelm drive")


def scenario_of(asked: Asked) -> Scenario:
    """The scenario with the options put in. Where it leads is left to who drives.

    Raises:
        CohelmError: naming the option, the key or the file.
    """
    start = asked.start
    goal = None
    if asked.map is not None:
        start = start or _roomiest(asked.map)
        spot = words.place(start, "--start", heading=True)
        goal = spot if isinstance(spot, str) else f"{spot[0]},{spot[1]}"
    return ride.scenario_of(
        ride.Asked(
            scenario=asked.scenario,
            map=asked.map,
            start=start,
            goal=goal,
            people=asked.people,
            robot=asked.robot,
            settings=asked.settings,
        )
    )


def _roomiest(map_: str) -> str:
    """Where on a map there is most room, and its places' first one where it names any."""
    places = places_beside(map_)
    if places.names:
        return str(places.names[0])
    grid = read_map(map_)
    room = distance_field(grid).distance
    cell = np.unravel_index(int(np.argmax(room)), room.shape)
    x, y = grid.centres(np.array(cell))
    return f"{x:.2f},{y:.2f}"
