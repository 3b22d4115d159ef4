import json

import numpy as np
import pytest

from cohelm.evaluation.report.socnav3 import trajectory
from cohelm.maps import OccupancyGrid


def test_absent_people_are_left_out_and_the_grid_runs_from_its_upper_row_down(made_ride):
    people = np.array([[[1.0, 2.0, 0.0, 0.0], [np.nan] * 4]] * 3)
    cells = np.array([[100, 0], [-1, 0]], dtype=np.int8)
    world = OccupancyGrid(data=cells, resolution=0.5, X_MG=[1.0, 2.0, 0.3])
    ride = made_ride(
        [[0, 0, np.pi / 2]] * 3, people=people, world=world, twist=[[1.0, 0.0, 0.0]] * 3
    )
    found = trajectory(ride)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert len(found["sequence"]) == 3
    first = found["sequence"][0]
    assert [each["id"] for each in first["people"]] == [0]
    assert (first["robot"]["speed_x"], first["robot"]["speed_y"]) == pytest.approx((0.0, 1.0))
    assert (first["goal"]["x"], first["goal"]["type"]) == (10.0, "go-to")
    assert found["grid"]["data"] == [[-1, 0], [1, 0]]
    assert (found["grid"]["x_orig"], found["grid"]["angle_orig"]) == (1.0, 0.3)
