"""What a page draws the floor from."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from cohelm.live.floor_model import floor_model, map_image
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import floor_of


def shades(png):
    return np.asarray(Image.open(BytesIO(png)))


def test_each_cell_is_a_pixel_and_the_first_row_is_the_top():
    data = np.array([[FREE, OCCUPIED, UNKNOWN], [OCCUPIED, FREE, FREE]], dtype=np.int8)
    floor, png = map_image(
        OccupancyGrid(data=data, resolution=0.5, X_MG=np.array([2.0, -1.0, 0.0]))
    )
    assert shades(png).tolist() == [[0, 255, 255], [255, 0, 128]]
    assert (floor.width, floor.height, floor.resolution) == (3, 2, 0.5)
    assert (floor.x, floor.y) == (2.0, -1.0)


@pytest.mark.parametrize("turn", [0.3, np.pi / 2.0, -2.0])
def test_a_turned_grid_is_drawn_upright(turn):
    data = np.full((12, 20), FREE, dtype=np.int8)
    data[2:5, 14:18] = OCCUPIED
    grid = OccupancyGrid(data=data, resolution=0.25, X_MG=np.array([1.0, 2.0, turn]))
    floor, png = map_image(grid)
    shade = shades(png)
    for cell, wanted in (((3, 16), 0), ((9, 4), 255), ((6, 10), 255)):
        x, y = grid.centres(np.array(cell))
        column = int((x - floor.x) / floor.resolution)
        row = floor.height - 1 - int((y - floor.y) / floor.resolution)
        assert shade[row, column] == wanted


def test_the_scene_names_places_doors_and_the_chair():
    scenario = load_scenario("hospital")
    found = floor_model(scenario, seed=3)
    scene = found.scene
    _, places, _, doors = floor_of(scenario)
    assert [place.name for place in scene.places] == list(places.names)
    assert len(scene.doors) == len(doors) > 0
    assert scene.chair.name == "quantum_q6_edge"
    assert scene.seed == 3
    assert scene.modes[0] == "shared"


def test_another_map_has_another_name_for_its_picture():
    names = {floor_model(load_scenario(s), 0).scene.floor.image for s in ("hospital", "empty")}
    assert len(names) == 2
