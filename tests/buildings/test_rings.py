"""Rooms around other rooms, and the names of storeys' files."""

import numpy as np
import pytest

from cohelm.maps import OccupancyGrid

pytest.importorskip("ifcopenshell")

from cohelm.buildings.free_space import partition
from cohelm.buildings.ifc_file import file_stems
from cohelm.buildings.storey import BuildingStorey, Room, room_cells
from cohelm.buildings.storey_files import room_places


def square(side):
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2.0


def test_a_room_does_not_contain_what_it_encloses():
    ring = Room(
        id="a", number="1", name="Corridor", polygons=(square(8.0),), holes=(square(4.0),), area=48
    )
    assert ring.contains((3.0, 0.0))
    assert not ring.contains((0.0, 0.0))
    grid = OccupancyGrid(
        data=np.zeros((100, 100), np.int8), resolution=0.1, X_MG=np.array([-5.0, -5.0, 0.0])
    )
    assert np.count_nonzero(room_cells(ring, grid)) * 0.01 == pytest.approx(48.0, rel=0.03)


def test_a_corridor_around_a_hall_in_a_plain_map_is_a_place_of_its_own():
    # a hall of 6 m with a door of 0.9 m, and a corridor of 2 m around it
    data = np.full((220, 220), 100, dtype=np.int8)
    data[4:216, 4:216] = 0
    data[46:174, 46:174] = 100
    data[50:170, 50:170] = 0
    data[100:118, 44:52] = 0
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    found = partition(grid)
    assert len(found.rooms) == 2
    assert [set(door.rooms) for door in found.doors] == [{room.id for room in found.rooms}]
    storey = BuildingStorey(
        name="ring", stem="ring", elevation=0.0, grid=grid, rooms=found.rooms, doors=found.doors
    )
    points = [place.point for place in room_places(storey)]
    for room, point in zip(found.rooms, points, strict=True):
        assert [each.id for each in found.rooms if each.contains(point)] == [room.id]


def test_files_of_storeys_have_different_names():
    assert file_stems(["Level 2", "Level"]) == ("level-2", "level")
    assert file_stems(["Level -1", "Level 0", "Level 1"]) == (
        "level-minus-1",
        "level-0",
        "level-1",
    )
    assert file_stems(["A", "A", "A 2", "二階", "../x"]) == ("a", "a-2", "a-2-2", "storey", "x")
