"""Floor plans: what is drawn where, derived cell by cell, and what is refused."""

import numpy as np
import pytest
import yaml

from cohelm.errors import ConfigError, MapError
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, FloorPlan, read_floor_plan

# Two rooms side by side, 0.1 m a cell, walls of 0.2 m: their middles at x = 1, 3, 5 and y = 1, 3.
PLAN = {
    "size": [6, 4],
    "resolution": 0.1,
    "wall": 0.2,
    "rooms": {"West": {"rect": [1, 1, 3, 3]}, "East": {"rect": [3, 1, 5, 3], "point": [4.5, 2]}},
    "doors": [{"at": [3, 2], "width": 1.2}],
}


def draw(**changes):
    return FloorPlan.model_validate({**PLAN, **changes}).draw()


def cell(grid, x, y):
    return int(grid.data[tuple(grid.cells([x, y]))])


def test_walls_stand_half_a_thickness_either_side_of_the_outline():
    grid, _ = draw(doors=[])
    assert grid.shape == (40, 60)
    row = grid.data[grid.cells([0.0, 2.0])[0]]
    # unknown up to 0.9, wall to 1.1, floor to 2.9, wall to 3.1, floor to 4.9, wall to 5.1, unknown
    runs = [(UNKNOWN, 9), (OCCUPIED, 2), (FREE, 18), (OCCUPIED, 2), (FREE, 18), (OCCUPIED, 2)]
    expected = np.repeat([v for v, _ in runs], [n for _, n in runs]).tolist() + [UNKNOWN] * 9
    assert row.tolist() == expected
    assert cell(grid, 2.0, 0.95) == OCCUPIED
    assert cell(grid, 2.0, 0.85) == UNKNOWN
    assert cell(grid, 2.0, 1.15) == FREE


def test_a_door_is_cut_to_its_width_through_the_whole_wall():
    grid, _ = draw()
    wall = grid.data[10:30, 29:31]  # y from 1 to 3, both cells of the wall between the rooms
    # floor between the outer walls, 1.1 … 2.9; the door is 1.4 … 2.6: 12 cells
    assert np.array_equal(wall[:, 0], wall[:, 1])
    assert wall[:, 0].tolist() == [OCCUPIED] * 4 + [FREE] * 12 + [OCCUPIED] * 4


def test_a_door_written_a_little_beside_its_wall_is_still_cut_into_it():
    grid, _ = draw()
    beside, _ = draw(doors=[{"at": [3.2, 2], "width": 1.2}])
    assert np.array_equal(grid.data, beside.data)


def test_spaces_that_overlap_are_open_to_one_another():
    grid, _ = draw(
        rooms={},
        doors=[],
        corridors={"A": {"rect": [1, 1, 3.4, 2]}, "B": {"rect": [2.6, 1, 5, 3]}},
    )
    assert (grid.data[12:19, 12:48] == FREE).all()  # y 1.2 … 1.9, x 1.2 … 4.8: no wall between
    assert cell(grid, 2.6, 2.5) == OCCUPIED


def test_what_is_outside_may_be_occupied():
    grid, _ = draw(outside="occupied")
    assert not (grid.data == UNKNOWN).any()
    assert cell(grid, 0.5, 0.5) == OCCUPIED


def test_furniture_stands_where_it_says():
    grid, _ = draw(
        furniture=[
            {"name": "table", "rect": [1.5, 1.5, 2.5, 1.7]},
            {"name": "column", "disc": [4, 2, 0.3]},
            {"name": "stool", "rect": [-0.1, -0.1, 0.1, 0.1], "at": [[1.5, 2.5], [2.5, 2.5]]},
        ]
    )
    bare, _ = draw()
    added = (grid.data == OCCUPIED) & (bare.data != OCCUPIED)
    centres = grid.centres(np.argwhere(added))
    x, y = centres.T
    table = (abs(x - 2.0) < 0.5) & (abs(y - 1.6) < 0.1)
    disc = np.hypot(x - 4.0, y - 2.0) < 0.3
    stools = (abs(abs(x - 2.0) - 0.5) < 0.1) & (abs(y - 2.5) < 0.1)
    assert (table | disc | stools).all()
    assert table.sum() == 10 * 2
    assert stools.sum() == 2 * 4
    # radius 3 cells about a corner of cells: of the 6 x 6 centres at ±0.5, ±1.5, ±2.5 all but the
    # four corners, at 3.54, lie inside; the farthest that do, at √8.5 = 2.92, are within the
    # 32-sided outline too, whose sides are 3·cos(π/32) = 2.99 away
    assert disc.sum() == 32


def test_a_turned_rect_is_a_rect_of_the_other_measures():
    lying, _ = draw(furniture=[{"rect": [1.4, 1.9, 2.4, 2.1], "turned": 90}])
    upright, _ = draw(furniture=[{"rect": [1.8, 1.5, 2.0, 2.5]}])
    assert np.array_equal(lying.data, upright.data)


def test_rooms_corridors_and_points_become_places():
    _, places = draw(places={"Window": [1.5, 2.5]}, furniture=[{"rect": [1.1, 1.1, 2.9, 2.0]}])
    assert places.names == ("West", "East", "Window")
    assert places.at([1.5, 1.5]) == "West"
    assert places.at([4.5, 1.5]) == "East"
    assert places.at([0.5, 0.5]) == ""
    assert places.find("East").point.tolist() == [4.5, 2.0]
    assert places.find("Window").point.tolist() == [1.5, 2.5]
    # the lower half of West is taken: the roomiest spot is the middle of what is left of it,
    # x 1.1 … 3, y 2.0 … 2.9, to within a cell
    assert places.find("West").point == pytest.approx([2.0, 2.45], abs=0.15)


def test_an_unknown_place_is_said_with_the_plans_file(tmp_path):
    file = tmp_path / "plan.yaml"
    file.write_text(yaml.safe_dump(PLAN))
    _, places = read_floor_plan(file).draw()
    with pytest.raises(MapError, match=r"plan\.yaml: no place 'Wset'; did you mean 'West'"):
        places.find("Wset")


def test_drawing_twice_gives_the_same():
    (a, _), (b, _) = draw(), draw()
    assert a.data.tobytes() == b.data.tobytes()


@pytest.mark.parametrize(
    ("changes", "key", "says"),
    [
        ({"size": [6, 0]}, "size.1", "greater than 0"),
        ({"resolution": -1}, "resolution", "greater than 0"),
        ({"walls": 0.2}, "walls", "did you mean 'wall'"),
        ({"outside": "lava"}, "outside", "'unknown' or 'occupied'"),
        ({"rooms": {"A": {"rect": [3, 1, 1, 3]}}}, "rooms.A.rect", "x0 < x1"),
        ({"rooms": {"A": {"rect": [1, 1, 3]}}}, "rooms.A.rect.3", "missing"),
        ({"rooms": {"A": {}}}, "rooms.A", "exactly one of rect, polygon"),
        ({"rooms": {"A": {"polygon": [[0, 0], [1, 1]]}}}, "rooms.A.polygon", "at least 3"),
        ({"rooms": {"A": {"rect": [1, 1, 7, 3]}}}, "rooms.A", "outside the map of 6 x 4 m"),
        ({"rooms": {}}, "rooms", "needs a room"),
        ({"corridors": {"west": {"rect": [1, 1, 2, 2]}}}, "corridors.west", "used twice"),
        ({"places": {"EAST": [1, 1]}}, "places.EAST", "used twice"),
        ({"places": {"Far": [9, 1]}}, "places.Far", "outside the map"),
        ({"doors": [{"at": [2, 2], "width": 1}]}, "doors.0", "no wall within 0.3 m of (2, 2)"),
        ({"doors": [{"at": [3, 2], "width": 1.9}]}, "doors.0", "its wall has 1.80 m there"),
        ({"doors": [{"at": [3, 2], "width": 0}]}, "doors.0.width", "greater than 0"),
        ({"furniture": [{"name": "ghost"}]}, "furniture.0", "exactly one of rect, disc, polygon"),
        ({"furniture": [{"disc": [1, 1, 0]}]}, "furniture.0", "the radius must be positive"),
        ({"furniture": [{"rect": [5.5, 1, 6.5, 2]}]}, "furniture.0", "outside the map"),
    ],
)
def test_a_plan_that_says_what_cannot_be(tmp_path, changes, key, says):
    file = tmp_path / "plan.yaml"
    file.write_text(yaml.safe_dump({**PLAN, **changes}))
    with pytest.raises(ConfigError) as caught:
        read_floor_plan(file)
    assert str(caught.value).startswith(str(file))
    assert caught.value.key == key
    assert says in str(caught.value)


def test_a_room_filled_with_furniture_has_no_place_to_go_to():
    with pytest.raises(ConfigError, match=r"rooms\.West: no free floor"):
        draw(furniture=[{"rect": [1, 1, 3, 3]}])


def test_no_such_plan(tmp_path):
    with pytest.raises(ConfigError, match="no such file"):
        read_floor_plan(tmp_path / "none.yaml")
