"""Rooms and doors of plain maps."""

import numpy as np
import pytest

from cohelm.buildings import partition, read_building
from cohelm.maps import NamedPlace, OccupancyGrid, Places

CELL = 0.05


def floor(width, height, *, blocks=()):
    """Free floor of so many metres, with walls around and blocks (x0, y0, x1, y1), m."""
    data = np.zeros((round(height / CELL), round(width / CELL)), dtype=np.int8)
    walls = [(0, 0, width, 0.2), (0, height - 0.2, width, height)]
    walls += [(0, 0, 0.2, height), (width - 0.2, 0, width, height)]
    for x0, y0, x1, y1 in (*walls, *blocks):
        rows, cols = (slice(round(a / CELL), round(b / CELL)) for a, b in ((y0, y1), (x0, x1)))
        data[rows, cols] = 100
    return OccupancyGrid(data=data, resolution=CELL, X_MG=np.array([3.0, -2.0, 0.0]))


def two_rooms(gap):
    """Rooms of 4 × 4 m and 3.4 × 4 m with a gap of so many metres between them, from y = 1 on."""
    return floor(8.0, 4.4, blocks=[(4.2, 0, 4.4, 1.0), (4.2, 1.0 + gap, 4.4, 4.4)])


@pytest.mark.parametrize("gap", [0.8, 1.0, 1.4])
def test_a_narrow_gap_is_a_door_of_that_width(gap):
    found = partition(two_rooms(gap))
    assert [room.area for room in found.rooms] == pytest.approx([16.0, 13.6], rel=0.03)
    (door,) = found.doors
    assert door.width == pytest.approx(gap, abs=CELL)
    assert door.point == pytest.approx([3.0 + 4.3, -2.0 + 1.0 + gap / 2.0], abs=0.15)
    assert abs(door.direction[1]) > 0.95
    assert set(door.rooms) == {room.id for room in found.rooms}
    for room in found.rooms:
        x, y = np.vstack([room.polygons[0], room.polygons[0][:1]]).T
        shoelace = 0.5 * abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
        assert shoelace == pytest.approx(room.area, rel=0.05)


@pytest.mark.parametrize("gap", [0.4, 2.5])
def test_a_wide_gap_joins_two_parts_and_a_narrow_one_is_no_door(gap):
    found = partition(two_rooms(gap))
    assert found.doors == ()
    assert len(found.rooms) == (1 if gap > 2.0 else 2)


def test_furniture_divides_no_room():
    tables = [(1.0 + 1.5 * k, 1.5, 1.8 + 1.5 * k, 2.5) for k in range(4)]
    assert len(partition(floor(8.0, 4.4, blocks=tables)).rooms) == 1


def test_a_corridor_is_a_room_with_its_doors():
    blocks = [(0, 2.0, 2.0, 2.2), (2.9, 2.0, 8.0, 2.2), (8.9, 2.0, 12.0, 2.2), (6.0, 2.0, 6.2, 6.0)]
    found = partition(floor(12.0, 6.0, blocks=blocks))
    assert len(found.rooms) == 3
    assert len(found.doors) == 2
    corridor = next(room.id for room in found.rooms if room.contains([9.0, -1.0]))
    assert all(corridor in door.rooms for door in found.doors)


def test_a_named_place_names_its_room():
    places = Places(places=(NamedPlace(name="Ward 3", point=np.array([5.0, 0.0])),))
    found = partition(two_rooms(0.9), places=places)
    assert [room.label for room in found.rooms] == ["Ward 3", "Room 2"]


def test_turning_the_map_turns_the_rooms():
    grid = two_rooms(0.9)
    turned = OccupancyGrid(data=grid.data, resolution=CELL, X_MG=np.array([0.0, 0.0, np.pi / 2.0]))
    (door,) = partition(grid).doors
    (other,) = partition(turned).doors
    x, y = door.point - [3.0, -2.0]
    assert other.point == pytest.approx([-y, x], abs=0.1)


def test_a_map_without_free_floor_has_no_rooms():
    grid = OccupancyGrid(
        data=np.full((20, 20), 100, dtype=np.int8), resolution=CELL, X_MG=np.zeros(3)
    )
    found = partition(grid)
    assert (found.rooms, found.doors) == ((), ())


@pytest.mark.filterwarnings("ignore::cohelm.maps.MapWarning")
def test_the_hospital_has_its_wards(data):
    (storey,) = read_building(data / "ros_maps" / "aws_hospital_sim.yaml")
    wards = [[-10.5, -5.0], [-10.5, -18.0], [8.3, -5.0], [8.3, -18.0]]
    found = [[room for room in storey.rooms if room.contains(point)] for point in wards]
    assert [len(rooms) for rooms in found] == [1, 1, 1, 1]
    ids = {rooms[0].id for rooms in found}
    assert len(ids) == 4
    for room in ids:
        assert sum(room in door.rooms for door in storey.doors) == 1
