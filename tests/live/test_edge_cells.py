"""Edges of the floor for the page: cells of its map as runs, sent when they change."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from cohelm.live import Drive, DriveSetup
from cohelm.live.control.cycle_state import PageView
from cohelm.live.control.view_model import MAX_RUNS, edge_cells
from cohelm.live.messages import EdgeCells
from cohelm.maps import OccupancyGrid
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import Scenario

from .rig import STEP, Rig


def grid(*pose):
    return OccupancyGrid(
        data=np.zeros((20, 40), dtype=np.int8), resolution=0.05, X_MG=np.array(pose)
    )


def test_cells_beside_each_other_are_one_run_in_any_order():
    cells = np.array([[5, 3], [-2, 7], [5, 2], [6, 4], [5, 4], [5, 9]])
    found = edge_cells(cells, grid(-1.0, 2.0, 0.0))
    assert found.runs == ((5, 2, 3), (-2, 7, 1), (5, 9, 1), (6, 4, 1))
    assert edge_cells(np.empty((0, 2), dtype=np.int64), grid(0.0, 0.0, 0.0)).runs == ()


def test_a_turned_map_has_its_edges_where_its_image_has_them():
    # By a quarter turn to the left, columns run upwards and rows to the left: the first is last.
    found = edge_cells(np.array([[0, 3], [1, 3]]), grid(0.0, 0.0, np.pi / 2.0))
    assert found.runs == ((3, 18, 2),)


def test_a_message_stays_small():
    rows, cols = np.divmod(np.arange(0, 4 * MAX_RUNS, 2), 160)
    cells = np.vstack([np.column_stack([rows, cols]), [[0, 1]]])
    found = edge_cells(cells, grid(0.0, 0.0, 0.0)).runs
    assert (len(found), found[0]) == (MAX_RUNS, (0, 0, 3))


def test_pages_get_the_edges_when_they_change_and_not_each_step():
    kerb = load_scenario("kerb").model_dump(exclude_unset=True)
    setup = build_scenario(
        Scenario(**{**kerb, "name": "near", "start": [4.5, 6.0, 0.0], "mode": "stop_only"}), 0
    )
    rig = Rig(setup)
    rig.drive()
    count = len(rig.steps(60, 0.6))
    sent = rig.of("edge_cells")
    assert 1 < len(sent) <= 1 + count * STEP
    assert all(one.runs != other.runs for one, other in pairwise(sent))
    kerb_column = round((7.0 - setup.grid.bounds[0]) / setup.grid.resolution)
    assert any(col >= kerb_column for _, col, _ in sent[-1].runs)
    rig.cycle.enter(rig.new_world())
    rig.steps(2)
    assert rig.of("edge_cells")[len(sent) :] == sent[:1]  # as at the first beginning


def test_a_page_that_comes_later_gets_them(tmp_path):
    drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path))
    edges, told = EdgeCells(runs=((1, 2, 3),)), []
    cycle = drive._loop.cycle
    cycle.state = replace(cycle.state, view=PageView(edges=edges))
    drive.listen(lambda message, _: told.append(message))
    drive.connect("late", "driver")
    assert told[-1] == edges
    drive.close()
