"""The floors that come with cohelm are buildings that a wheelchair can be ridden in."""

from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import label
from skimage.graph import MCP_Geometric

import cohelm
from cohelm.maps import FREE, distance_field, read_floor_plan

FLOORS = Path(cohelm.__file__).parent / "scenarios" / "floors"

HALF_WIDTH = 0.305
"""Of the default chair, m."""


@pytest.fixture(scope="module")
def hospital():
    plan = read_floor_plan(FLOORS / "hospital.yaml")
    return plan, *plan.draw()


def shortest(grid, start, goal, *, clearance):
    """Length, m, of the shortest way with that clearance along the cells' eight directions."""
    costs = np.where(distance_field(grid).distance > clearance, 1.0, -1.0)
    search = MCP_Geometric(costs)
    found, _ = search.find_costs([tuple(grid.cells(start))], [tuple(grid.cells(goal))])
    return found[tuple(grid.cells(goal))] * grid.resolution


@pytest.mark.parametrize("file", sorted(FLOORS.glob("*.yaml")), ids=lambda f: f.stem)
def test_every_place_can_be_reached_from_every_other_by_wheelchair(file):
    grid, places = read_floor_plan(file).draw()
    passable = distance_field(grid).distance > HALF_WIDTH + 0.05
    regions, _ = label(passable)
    found = {place.name: int(regions[tuple(grid.cells(place.point))]) for place in places}
    assert 0 not in found.values(), found
    assert len(set(found.values())) == 1, found


def test_places_lie_in_themselves(hospital):
    _, _, places = hospital
    for place in places:
        assert place.contains(place.point), place.name


def test_the_hospital_has_what_a_floor_has(hospital):
    plan, grid, places = hospital
    assert grid.size == pytest.approx((41.0, 26.0))  # 40 x 25 m between the outer walls' middles
    for name in ("Reception", "Cafeteria", "Pharmacy", "Radiology", "Waiting area", "Therapy",
                 "Nurses' station", "Ward 1", "Ward 2", "Ward 3", "Ward 4"):  # fmt: skip
        assert places.find(name).name == name
    assert min(door.width for door in plan.doors) >= 1.2


def test_the_corridors_let_a_wheelchair_and_a_person_pass(hospital):
    # The middle of each corridor is clear by 1.3 m all along: 2.6 m from wall to wall.
    _, grid, _ = hospital
    field = distance_field(grid)
    for a, b in [((9, 18), (39, 18)), ((9, 8), (39, 8)), ((25, 8), (25, 18)), ((39, 8), (39, 18))]:
        middle = np.linspace(a, b, 200)
        assert field.at(middle).min() >= 1.3, (a, b)


def test_the_ride_from_ward_3_to_the_cafeteria_is_25_to_35_m(hospital):
    _, grid, places = hospital
    length = shortest(
        grid, places.find("Ward 3").point, places.find("Cafeteria").point, clearance=0.36
    )
    assert 25.0 < length < 35.0


def test_another_way_leads_from_reception_to_the_cafeteria(hospital):
    plan, grid, places = hospital
    ends = places.find("Reception").point, places.find("Cafeteria").point
    direct = shortest(grid, *ends, clearance=0.36)
    closed = plan.model_copy(
        update={"furniture": (*plan.furniture, *_barrier([18.0, 6.6, 18.5, 9.4]))}
    )
    round_the_core = shortest(closed.draw()[0], *ends, clearance=0.36)
    assert direct < round_the_core < 1.5 * direct


def test_the_hall_is_empty_and_crossed_over_10_m(tmp_path):
    grid, places = read_floor_plan(FLOORS / "hall.yaml").draw()
    assert grid.size == pytest.approx((14.0, 14.0))
    assert (grid.data[2:-2, 2:-2] == FREE).all()
    for a, b in (("West", "East"), ("South", "North")):
        assert np.hypot(*(places.find(a).point - places.find(b).point)) == pytest.approx(10.0)


def _barrier(rect):
    from cohelm.maps import Furniture

    return (Furniture(name="barrier", rect=tuple(rect)),)
