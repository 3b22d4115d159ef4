"""`cohelm map-changes`: shown, applied to a copy, forgotten."""

import json

import numpy as np
import pytest

from cohelm.health import MapChanges
from cohelm.health.map_changes import PERSISTENT
from cohelm.live.sessions.database import FILE, Database
from cohelm.live.sessions.map_changes import keep_changes
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid, read_map, write_map


@pytest.fixture
def ward(tmp_path):
    """A map with a wall at 1 m, and a data folder in which a ride has seen through the wall."""
    data = np.zeros((40, 40), dtype=np.int8)
    data[:, 20] = OCCUPIED
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    write_map(grid, tmp_path / "ward.yaml")
    found = MapChanges(np.array([[4, 3, 0]]), np.array([PERSISTENT]))
    keep_changes(Database(tmp_path / "data"), read_map(tmp_path / "ward.yaml"), "ward", found)
    return tmp_path


def test_it_shows_where_a_wall_is_gone(ward, cohelm):
    code, out, _ = cohelm("map-changes", "show", "--data", ward / "data")
    assert code == 0
    assert "ward" in out
    assert "a wall of the map is not there at (1.1, 0.9)" in out
    code, out, _ = cohelm("map-changes", "show", "--data", ward / "data", "--json")
    (record,) = json.loads(out).values()
    assert record["gone"] == [[1.125, 0.875]]
    assert record["new"] == []


def test_a_copy_gets_the_changes_and_the_map_stays(ward, cohelm):
    map_, copy = ward / "ward.yaml", ward / "new.yaml"
    before = (ward / "ward.pgm").read_bytes()
    given = ("map-changes", "apply", map_, "--out", copy, "--data", ward / "data")
    assert cohelm(*given)[0] == 0
    assert (ward / "ward.pgm").read_bytes() == before
    data = read_map(copy).data
    assert (data[15:20, 20] == FREE).all()
    assert (data[:15, 20] == OCCUPIED).all()
    code, _, err = cohelm(*given)  # it never replaces a file
    assert code == 2
    assert "exists" in err


def test_wrong_input_is_one_line(ward, cohelm):
    other = ward / "other.yaml"
    empty = np.zeros((4, 4), dtype=np.int8)
    write_map(OccupancyGrid(data=empty, resolution=0.05, X_MG=np.zeros(3)), other)
    code, out, _ = cohelm("map-changes", "apply", other, "--out", ward / "x.yaml", "--data", ward)
    assert code == 1
    assert "nothing is written" in out
    assert not (ward / "x.yaml").exists()
    code, _, err = cohelm("map-changes", "apply", other, "--out", ward / "x.png")
    assert (code, "--out" in err) == (2, True)
    (ward / "data" / FILE).write_text("{" * 1000)
    code, _, err = cohelm("map-changes", "show", "--data", ward / "data")
    assert (code, FILE in err) == (2, True)


def test_it_forgets(ward, cohelm):
    assert cohelm("map-changes", "forget", "nothing", "--data", ward / "data")[0] == 1
    assert cohelm("map-changes", "forget", "--data", ward / "data")[0] == 0
    assert "no map" in cohelm("map-changes", "show", "--data", ward / "data")[1]
