"""Damaged scenarios, robots, maps and places: an error of one line with the file, or a ride.

And numbers that are not plausible in a scenario are refused with the name of their key.
"""

import numpy as np
import pytest
import yaml
from tests.mutated import LONGEST, MOST_MEMORY, PARTS, fuzzed

from cohelm.errors import ScenarioError
from cohelm.maps import read_map, read_places, write_map
from cohelm.maps.grid import OccupancyGrid
from cohelm.robots import load_robot
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

SCENARIO = """\
description: a walk
map: hall.yaml
start: [1.5, 2.0, 90.0]
goal: Ward
robot: chair.yaml
prefer: [[3.0, 3.0]]
avoid: [{points: [[4.0, 1.5]], radius: 0.3}]
mode: shared
rider: {use: nudge, side: left}
profile: {preferred_speed: 0.7, social_distance: 0.6}
people: {count: 2, see_robot: true}
obstacles: [{at: [5.0, 1.0], radius: 0.2, height: 0.9}]
local_planner: {use: ss_mpc_dcbf, steps: 20}
faults: [{kind: scan_nan, at: 1.0, duration: 0.5}]
time_limit: 20.0
seed: 3
"""
ROBOT = """\
name: chair
footprint: [[0.55, 0.32], [-0.45, 0.32], [-0.45, -0.32], [0.55, -0.32]]
max_speed: 1.0
max_reverse_speed: 0.3
max_turn_rate: 1.0
max_acceleration: 0.6
max_deceleration: 0.8
emergency_deceleration: 1.5
max_turn_acceleration: 2.0
actuation_lag: 0.1
lasers:
  - {name: front, pose: [0.5, 0.0, 0.0], field_of_view_deg: 270, beams: 540, range_max: 10.0}
"""
PLACES = "Ward: [6.5, 2.5]\nHall: {polygon: [[1, 1], [3, 1], [3, 3], [1, 3]]}\n"


@pytest.fixture
def folder(tmp_path):
    """A scenario with its robot, map and places."""
    cells = np.zeros((40, 80), dtype=np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    grid = OccupancyGrid(data=cells, resolution=0.1, X_MG=np.zeros(3))
    write_map(grid, tmp_path / "hall.yaml", "pgm")
    write_map(grid, tmp_path / "other.yaml", "png")
    (tmp_path / "scenario.yaml").write_text(SCENARIO)
    (tmp_path / "chair.yaml").write_text(ROBOT)
    (tmp_path / "hall.places.yaml").write_text(PLACES)
    return tmp_path


def built(file):
    return build_scenario(load_scenario(file), 0).start, ()


READERS = {
    "scenario.yaml": built,
    "chair.yaml": lambda file: (load_robot(file), ()),
    "hall.yaml": lambda file: (read_map(file), ()),
    "hall.pgm": lambda file: (read_map(file.with_suffix(".yaml")), ()),
    "other.png": lambda file: (read_map(file.with_suffix(".yaml")), ()),
    "hall.places.yaml": lambda file: (read_places(file), ()),
}


@pytest.mark.parametrize("copies", PARTS)
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_refused_in_one_line(folder, name, copies):
    file = folder / name
    tally = fuzzed(
        file, file.read_bytes(), READERS[name],
        copies=copies, seed=1, difference=lambda *_: "",
    )  # fmt: skip
    assert "not one line" not in tally.counts
    assert tally.counts["refused"] > 0.1 * len(copies), str(tally)
    assert tally.slowest < LONGEST, str(tally)
    assert tally.memory < MOST_MEMORY, str(tally)


def numbers(data, path=()):
    """Paths of all real numbers in nested mappings and lists."""
    if isinstance(data, float):
        yield path
    elif isinstance(data, dict | list):
        for key, below in data.items() if isinstance(data, dict) else enumerate(data):
            yield from numbers(below, (*path, key))


@pytest.mark.parametrize("path", list(numbers(yaml.safe_load(SCENARIO))), ids=lambda path: path[0])
@pytest.mark.parametrize("absurd", [1e300, -1e300, 5e9, float("nan")])
def test_a_number_that_is_not_plausible_is_refused_with_its_key(folder, path, absurd):
    data = yaml.safe_load(SCENARIO)
    at = data
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = absurd
    file = folder / "scenario.yaml"
    file.write_text(yaml.safe_dump(data))
    with pytest.raises(ScenarioError) as error:
        load_scenario(file)
    assert str(path[0]) in error.value.key


def test_no_ride_is_shorter_than_a_control_step(folder):
    file = folder / "scenario.yaml"
    file.write_text(yaml.safe_dump(yaml.safe_load(SCENARIO) | {"time_limit": 1e-300}))
    with pytest.raises(ScenarioError) as error:
        load_scenario(file)
    assert error.value.key == "time_limit"
