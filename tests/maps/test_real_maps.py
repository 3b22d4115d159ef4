"""Every map of the outside collection reads, and survives being written."""

import os
import warnings
from pathlib import Path

import numpy as np
import pytest

from cohelm.maps import FREE, OCCUPIED, UNKNOWN, MapWarning, read_map, write_map

pytestmark = pytest.mark.data

# Cells (rows, cols), side of a cell and corner, as the files' own headers and YAMLs state them.
MAPS = {
    "aws_hospital_sim.yaml": ((1128, 509), 0.05, (-13.8, -36.3)),
    "hunav_bookstore_sim.yaml": ((292, 312), 0.05, (-7.77, -7.32)),
    "intel_lab.yaml": ((581, 579), 0.1, (0.0, 0.0)),
    "nav2_depot.yaml": ((307, 604), 0.05, (0.0, 0.0)),
    "nav2_tb3_sandbox.yaml": ((384, 384), 0.05, (-10.0, -10.0)),
    "nav2_warehouse.yaml": ((1674, 1006), 0.03, (-15.1, -25.0)),
    "utexas_gdc_1.yaml": ((1255, 1857), 0.05, (-60.45, -23.4)),
    "utexas_gdc_1n.yaml": ((573, 1857), 0.05, (-60.45, -23.4)),
    "utexas_gdc_3ne.yaml": ((573, 1857), 0.05, (-60.45, -23.4)),
    "enps_office.pgm": ((395, 784), 0.05, (0.0, 0.0)),
}

MASKS = {"nav2_depot_keepout.yaml", "nav2_depot_speed.yaml"}
"""Read in test_masks."""


@pytest.fixture
def folder():
    data = os.environ.get("COHELM_DATA")
    found = Path(data) / "ros_maps" if data else None
    if found is None or not found.is_dir():
        pytest.skip("needs ros_maps in the folder that COHELM_DATA names")
    return found


def read(file):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        return read_map(file)


@pytest.mark.parametrize("name", MAPS)
def test_a_real_map_reads_and_survives_being_written(folder, tmp_path, name):
    shape, resolution, corner = MAPS[name]
    grid = read(folder / name)
    assert grid.shape == shape
    assert grid.resolution == resolution
    assert grid.X_MG.tolist() == [*corner, 0.0]
    assert set(np.unique(grid.data)) <= {UNKNOWN, FREE, OCCUPIED}
    assert (grid.data == FREE).any()
    assert (grid.data == OCCUPIED).any()
    for image_format in ("pgm", "png"):
        write_map(grid, tmp_path / "m.yaml", image_format)
        assert read_map(tmp_path / "m.yaml").data.tobytes() == grid.data.tobytes()


def test_no_map_of_the_collection_is_missing_here(folder):
    present = {f.name for f in folder.glob("*.yaml")}
    present |= {f.name for f in folder.glob("*.pgm") if not f.with_suffix(".yaml").is_file()}
    assert present == set(MAPS) | MASKS


def test_shade_205_is_unknown_where_the_thresholds_say_so_and_free_where_they_do(folder):
    assert (read(folder / "nav2_tb3_sandbox.yaml").data == UNKNOWN).sum() == 138_683
    # free_thresh 0.25 in this one: nothing is left unknown, and that is said
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        grid = read_map(folder / "aws_hospital_sim.yaml")
    assert not (grid.data == UNKNOWN).any()
    said = " ".join(str(w.message) for w in caught)
    assert "'hospital.pgm' does not exist" in said
    assert "takes 48997 pixels of shade 205" in said
