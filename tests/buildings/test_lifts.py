"""Lifts joined across the storeys of authored models."""

import numpy as np
import pytest
from tests.buildings.authored import lift_tower

from cohelm.buildings import lifts_of, read_building
from cohelm.geometry import distance_to_polygon


def lifts(author, folder, notes=None):
    return lifts_of(read_building(author.write(folder / "model.ifc")), notes)


@pytest.mark.parametrize("marked", [("element",), ("room",), ("room", "element")])
def test_a_lift_joins_the_storeys_that_its_doors_open_on(tmp_path, marked):
    (lift,) = lifts(lift_tower(marked=marked), tmp_path)
    assert lift.name == "Lift A"
    assert [landing.storey for landing in lift.landings] == [1, 2, 3]
    for landing in lift.landings:
        assert len(landing.doors) == 1
        assert distance_to_polygon(landing.polygon, 5.0, 1.0) < 0.0
        assert np.ptp(landing.polygon, axis=0) == pytest.approx([1.6, 1.6], abs=0.41)


def test_a_storey_without_a_door_is_not_served(tmp_path):
    (lift,) = lifts(lift_tower(doors=(True, False, True)), tmp_path)
    assert [landing.storey for landing in lift.landings] == [1, 3]


def test_a_floor_above_the_shaft_is_not_served(tmp_path):
    (lift,) = lifts(lift_tower(roof=True), tmp_path)
    assert [landing.storey for landing in lift.landings] == [1, 2, 3]


def test_an_open_shaft_is_entered_from_the_floor_around_it(tmp_path):
    (lift,) = lifts(lift_tower(walls=False), tmp_path)
    assert [(landing.storey, landing.doors) for landing in lift.landings] == [
        (1, ()), (2, ()), (3, ()),
    ]  # fmt: skip


def test_two_lifts_side_by_side_are_two(tmp_path):
    found = lifts(lift_tower(lifts=2), tmp_path)
    assert [lift.name for lift in found] == ["Lift A", "Lift B"]
    doors = [landing.doors for lift in found for landing in lift.landings]
    assert len({each for ids in doors for each in ids}) == 6


def test_a_lift_of_one_storey_is_a_note(tmp_path):
    notes = []
    assert lifts(lift_tower(doors=(True, False, False)), tmp_path, notes) == ()
    assert notes == ["the lift 'Lift A' serves one storey only: it is left out"]


def test_a_lift_lobby_is_no_lift(tmp_path):
    author = lift_tower(marked=())
    author.box("IfcSpace", (0.2, 0.2, 0), (3.8, 3.0, 2.5), Name="Lift Lobby")
    assert lifts(author, tmp_path) == ()
