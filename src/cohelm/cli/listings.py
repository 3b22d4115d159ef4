"""``cohelm scenarios``, ``robots``, ``plugins`` and ``data``: tables of everything available."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from rich.table import Table

from cohelm import plugins as parts
from cohelm.cli.report import OUTPUT, print_line
from cohelm.config import read_yaml
from cohelm.errors import ScenarioError
from cohelm.recordings.outside_data import outside_data
from cohelm.scenarios.collection import Collection


class DataSet(NamedTuple):
    """External data set; nothing of it comes with cohelm."""

    folder: str
    holds: str
    sources: tuple[tuple[str, str], ...]
    """(public source, licence) of each part."""


DATA_SETS = (
    DataSet(
        "ros_maps",
        "occupancy maps of real and simulated buildings",
        (
            ("ros-navigation/navigation2", "Apache-2.0"),
            ("utexas-bwi/bwi_common", "BSD"),
            ("RGNC/enps_rrt", "GPL-3.0"),
            ("Docencia-fmrico/plansys2-hospital-cavros", "Apache-2.0"),
            ("robotics-upo/hunav_sim", "MIT"),
        ),
    ),
    DataSet(
        "movingai", "grid maps with the optimal lengths of paths", (("nathansttt/hog2", "MIT"),)
    ),
    DataSet(
        "pedestrians",
        "recorded pedestrians: ETH, UCY, HERMES",
        (("crowdbotp/OpenTraj", "see each set"), ("quancore/social-lstm", "see each set")),
    ),
    DataSet(
        "lidar",
        "people in laser scans and point clouds",
        (
            ("angusleigh/leg_tracker", "BSD-3-Clause"),
            ("kuixu/kitti_object_vis", "KITTI: CC BY-NC-SA 3.0"),
            ("udacity/SFND_Lidar_Obstacle_Detection", "none stated"),
        ),
    ),
    DataSet(
        "ifc",
        "building models",
        (
            ("youshengCode/IfcSampleFiles", "none stated"),
            ("opensourceBIM/TestFiles", "GPL-3.0"),
            ("andrewisen/bim-whale-ifc-samples", "MIT"),
        ),
    ),
    DataSet(
        "crowdnav",
        "people of the 500 circle-crossing test cases, recorded",
        (("vita-epfl/CrowdNav", "MIT"),),
    ),
    DataSet(
        "socnav1",
        "ratings of the place of a robot among people",
        (("ljmanso/SocNav1", "CC BY 4.0"),),
    ),
    DataSet(
        "barn", "300 cluttered worlds with reference paths", (("Daffan/the-barn-challenge", "MIT"),)
    ),
)


def scenarios(plot: Path | None = None) -> int:
    """List the scenarios under their headings, and draw each if a folder is given."""
    files = resources.files("cohelm.scenarios") / "library"
    found = sorted(file.name for file in files.iterdir() if file.name.endswith(".yaml"))
    # The files alone: to validate them takes the robots, which take seconds.
    told = {name.removesuffix(".yaml"): read_yaml(Path(str(files / name))) for name in found}
    table = _table("scenario", "floor", "people", "description")
    for collection in Collection:
        members = {k: each for k, each in told.items() if each.get("collection") == collection}
        if not members:
            continue
        table.add_section()
        table.add_row("", "", "", f"[bold]{collection.heading}[/]")
        for name, each in members.items():
            floor = each.get("floor") or Path(each.get("map", "")).stem
            people = str(count_people(each.get("people", {})))
            table.add_row(name, floor, people, each["description"])
    OUTPUT.print(table)
    if plot is not None:
        _draw(list(told), plot)
    return 0


def count_people(people: Mapping[str, Any]) -> int:
    """Count the pedestrians of a scenario's file, as ``scenarios.crowd.pedestrian_count`` does."""
    if people.get("count") is not None:
        return int(people["count"])
    groups = sum(group.get("size", 2) for group in people.get("groups", ()))
    flows = sum(flow.get("count", 6) for flow in people.get("flows", ()))
    return int(len(people.get("pedestrians", ())) + groups + flows)


def _draw(names: Sequence[str], folder: Path) -> None:
    from cohelm.scenarios.build import build_scenario
    from cohelm.scenarios.picture import draw_scenario
    from cohelm.scenarios.scenario import load_scenario

    drawn = 0
    for name in names:
        scenario = load_scenario(name)
        try:
            draw_scenario(build_scenario(scenario, scenario.seed), folder / f"{name}.png")
        except ScenarioError as cause:  # it needs a file of the user
            print_line(f"not drawn: {cause}")
        else:
            drawn += 1
    print_line(f"written: {drawn} pictures to {folder}")


def robots() -> int:
    """List the wheelchairs with size, speed and sensors."""
    import numpy as np

    from cohelm.robots import load_robot, robot_names

    table = _table("robot", "size, m", "maximum speed, m/s", "sensors")
    for name in robot_names():
        robot = load_robot(name)
        length, width = np.ptp(robot.outline, axis=0)
        sensors = [
            *(f"{laser.name}: {laser.beams} beams" for laser in robot.lasers),
            *(f"{lidar.name}: {lidar.rings} × {lidar.azimuths}" for lidar in robot.lidars),
            *(f"{eye.name}: {eye.columns} × {eye.rows}" for eye in robot.depth_cameras),
        ]
        speed = f"{robot.max_speed:g}"
        table.add_row(name, f"{length:.2f} × {width:.2f}", speed, ", ".join(sensors))
    OUTPUT.print(table)
    return 0


def plugins() -> int:
    """List every installed part, without importing any."""
    table = _table("name", "class", "from")
    for group in parts.GROUPS:
        table.add_row("", f"[bold]{group}[/]")
        for name in parts.names(group):
            table.add_row(name, *parts.origin(group, name))
        table.add_section()
    OUTPUT.print(table)
    return 0


def data() -> int:
    """List the external data sets: present or absent, with public sources and licences."""
    root = outside_data()
    for each in DATA_SETS:
        folder = root / each.folder if root is not None else None
        present = folder is not None and folder.is_dir() and any(folder.iterdir())
        here = "[green]present[/]" if present else "[yellow]absent [/]"
        OUTPUT.print(f"[bold]{each.folder:12}[/]{here}  {each.holds}")
        for source, licence in each.sources:
            OUTPUT.print(f"[dim]{'':21}github.com/{source}  ({licence})[/]", soft_wrap=True)
    print_line("set COHELM_DATA to their folder" if root is None else f"COHELM_DATA is {root}")
    return 0


def _table(*columns: str) -> Table:
    table = Table(header_style="dim", show_edge=False, pad_edge=False)
    for i, column in enumerate(columns):
        table.add_column(column, overflow="fold", style="bold" if i == 0 else None)
    return table
