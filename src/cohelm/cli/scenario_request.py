"""Turn the options of ``cohelm run`` and ``cohelm drive`` into a scenario."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cohelm.cli import parsing
from cohelm.cli.requests import RunRequest
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.plugins import names
from cohelm.robots import load_robot
from cohelm.scenarios import Scenario, load_scenario
from cohelm.scenarios.crowd import pedestrian_count
from cohelm.scenarios.scenario import PARTS

PEOPLE_ON_A_MAP = 12
"""Pedestrians on your own map, where the scenario has none."""

_PART_OPTIONS = {
    "local_planner": ("--planner", "planner"),
    "global_planner": ("--method", "method"),
    "rider": ("--rider", "rider"),
}
_KEY_OPTIONS = ("start", "goal", "prefer", "people", "robot", "mode", "map")
"""Scenario keys that an option of the same name sets."""
_PLACED = (
    "floor", "floor_plan", "rider_goal", "rider_route", "companion", "prefer", "stroke", "avoid",
    "obstacles", "doors", "filters", "crowding",
)  # fmt: skip
"""Scenario keys with positions on the floor, which mean nothing on another map."""


def scenario_of(request: RunRequest) -> Scenario:
    """Load the scenario and apply the options; ``--set`` comes last.

    Raises:
        ConfigError, ScenarioError: naming the option, or the key in the scenario's file.
    """
    base = load_scenario(request.scenario)
    changes: dict[str, Any] = _on_map(base, request) if request.map is not None else {}
    if request.start is not None:
        changes["start"] = parsing.place(request.start, "--start", heading=True)
    if request.goal is not None:
        changes["goal"] = parsing.place(request.goal, "--goal")
    if request.prefer:
        changes["prefer"] = [parsing.point(text, "--prefer") for text in request.prefer]
    if request.robot is not None:
        changes["robot"] = _robot(request.robot)
    if request.mode is not None:
        changes["mode"] = request.mode
    if request.platform is not None and request.platform != base.platform["use"]:
        if ":" not in request.platform:
            _check_installed("platforms", request.platform, "--platform")
        changes["platform"] = {"use": request.platform}
    for key, (option, field) in _PART_OPTIONS.items():
        name = getattr(request, field)
        if name is not None and name != getattr(base, key)["use"]:
            if ":" not in name:
                _check_installed(PARTS[key][0], name, option)
            changes[key] = {"use": name}
    settings = [] if request.people is None else [f"people.count={request.people}"]
    with named_after_options(request):
        return load_scenario(request.scenario, [*settings, *request.settings], changes)


@contextlib.contextmanager
def named_after_options(request: RunRequest) -> Iterator[None]:
    """Let errors name the option that set the key at fault, not the scenario's file.

    Raises:
        ConfigError: with the option, or ``--set`` and the key, in place of file and key.
    """
    try:
        yield
    except ConfigError as error:
        option = _option_for(request, error.key)
        if option is None:
            raise
        raise ConfigError(error.problem, key=option) from None


def check_record(file: Path) -> None:
    """Refuse to overwrite a recording, or to record where nothing can be written.

    Raises:
        ConfigError: naming the option and the file.
    """
    if file.suffix.lower() != ".mcap":
        raise ConfigError(f"{file}: write a recording as FILE.mcap", key="--record")
    if file.exists():
        raise ConfigError(f"{file} exists already; name another file", key="--record")
    if not file.absolute().parent.is_dir():
        raise ConfigError(f"no folder {file.absolute().parent}", key="--record")


def _option_for(request: RunRequest, key: str) -> str | None:
    """The option that set a scenario key; a setting comes after it and wins."""
    top = key.partition(".")[0]
    for setting in request.settings:
        if top and setting.partition("=")[0].strip().partition(".")[0] == top:
            return f"--set {key}"
    if top in _KEY_OPTIONS and getattr(request, top) not in {None, ()}:
        return f"--{top}"
    option, field = {**_PART_OPTIONS, "platform": ("--platform", "platform")}.get(top, ("", ""))
    return option if option and getattr(request, field) is not None else None


def _on_map(base: Scenario, request: RunRequest) -> dict[str, Any]:
    """Changes that move a scenario to another map: everything with a position is dropped."""
    if request.start is None or request.goal is None:
        if not Path(request.map or "").exists():
            raise ConfigError(f"no file {request.map}", key="--map")
        raise ConfigError("a map of your own needs --start x,y and --goal x,y", key="--map")
    people = base.people.model_dump(
        mode="json", exclude={"pedestrians", "grouped", "groups", "flows"}
    )
    if people["count"] is None:
        people["count"] = pedestrian_count(base.people) or PEOPLE_ON_A_MAP
    return {
        **dict.fromkeys(_PLACED),
        "map": str(Path(request.map or "").absolute()),
        "rider": {"use": base.rider["use"]},
        "people": people,
        "time_limit": 600.0,
    }


def _check_installed(group: str, name: str, option: str) -> None:
    """Refuse an unknown part, naming the option that asks for it."""
    known = names(group)
    if name not in known:
        kind = group.replace("_", " ").removesuffix("s")
        raise ConfigError(f"no {kind} is called {name!r}{nearest(name, known)}", key=option)


def _robot(name_or_file: str) -> str:
    file = Path(name_or_file)
    name = str(file.absolute()) if file.suffix in {".yaml", ".yml"} else name_or_file
    try:
        load_robot(name)
    except ConfigError as error:
        if error.file is not None:
            raise
        raise ConfigError(error.problem, key="--robot") from None
    return name
