"""Heights and outlines for the 3-D view."""

import numpy as np
import pytest

from cohelm.geometry import distance_to_polygon
from cohelm.live.floor_model import floor_solids
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import floor_of
from cohelm.scenarios.floor import floor_plan
from cohelm.scenarios.objects import Obstacle

GLASS = Obstacle(at=(5.0, 8.0), size=(2.0, 0.1), angle_deg=90.0, sensed=False)
BOX = Obstacle(at=(6.0, 8.0), radius=0.3, height=0.5)
WET = Obstacle(at=(7.0, 8.0), size=(1.0, 1.0), solid=False)


def test_furniture_has_the_heights_of_the_drawn_floor():
    scenario = load_scenario("hospital")
    floor = floor_of(scenario)
    found = floor_solids(scenario)
    assert found.wall_height == scenario.storey.wall_height
    pieces = [each for each in floor_plan(scenario).furniture if each.height is not None]
    assert len(found.solids) == sum(len(each.at) for each in pieces) > 100
    for solid in found.solids:
        (r0, c0), (r1, c1) = (floor.grid.cells(f(solid.outline, axis=0)) for f in (np.min, np.max))
        assert np.isclose(floor.heights[r0:r1, c0:c1], solid.height).any()


def test_glass_obstacles_and_wet_floor_are_the_simulated_world_s():
    scenario = load_scenario("hospital").model_copy(update={"obstacles": (GLASS, BOX, WET)})
    found = floor_solids(scenario)
    glass, box = [each for each in found.solids if not each.on_map]
    assert (glass.glass, glass.height) == (True, scenario.storey.wall_height)
    # 2 m wide and turned by a quarter: 0.1 m along x, 2 m along y
    assert np.ptp(glass.outline, axis=0) == pytest.approx([0.1, 2.0])
    assert (box.glass, box.height) == (False, 0.5)
    assert distance_to_polygon(np.array(box.outline), 6.0, 8.0) == pytest.approx(-0.3, abs=0.002)
    assert len(found.wet) == 1


def test_a_floor_from_a_map_file_has_no_furniture():
    scenario = load_scenario("hospital").model_copy(update={"floor": None, "map": "map.yaml"})
    assert floor_solids(scenario).solids == ()
