"""The benchmark of narrow doorways: rides, widths and options."""

import numpy as np
import pytest

from cohelm.benchmarks.rides import doorways
from cohelm.errors import ConfigError, PluginError
from cohelm.maps import distance_field
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario


def columns(ride):
    return dict(ride.columns)


def test_every_seed_has_every_door_and_hand():
    tasks = doorways.create(modes="assisted,manual").tasks(range(2))
    kinds = len(doorways.SCENES) * len(doorways.WIDTHS) * len(doorways.RIDERS)
    assert len(tasks) == 2 * kinds
    assert all([columns(each)["mode"] for each in task] == ["assisted", "manual"] for task in tasks)
    for task in tasks:
        worlds = {tuple(s for s in r.settings if not s.startswith("mode=")) for r in task}
        assert len(worlds) == 1


@pytest.mark.parametrize("width", doorways.WIDTHS)
@pytest.mark.parametrize("name", doorways.SCENES)
def test_a_door_is_as_wide_as_its_name_says(name, width):
    scenario = load_scenario(name, [f"floor_plan.doors.0.width={width}"])
    stage = build_scenario(scenario, 0)
    across = np.column_stack([np.full(401, 6.5), np.linspace(2.5, 4.5, 401)])
    free = distance_field(stage.grid).at(across) > 0.0
    assert free.sum() * 0.005 == pytest.approx(width, abs=0.01)
    assert np.ptp(np.asarray(stage.robot.footprint)[:, 1]) < width - 0.1


def test_a_seed_moves_the_start():
    one, other = (doorways.create(modes="assisted").tasks(range(s, s + 1))[0][0] for s in (0, 1))
    assert one.load().start != other.load().start


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"riders": "idle"}, (ConfigError, PluginError)),
        ({"modes": "fast"}, ConfigError),
        ({"settings": ("rider.use=ideal",)}, ConfigError),
        ({"settings": ("floor_plan.doors.0.width=1.0",)}, ConfigError),
    ],
)
def test_what_is_compared_cannot_be_set(given, error):
    with pytest.raises(error):
        doorways.create(**given)
