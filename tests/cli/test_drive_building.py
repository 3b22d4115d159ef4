"""``cohelm drive --map FOLDER``: the storeys of a building and its lifts."""

import contextlib
from dataclasses import replace

import pytest
from tests.buildings.authored import lift_tower

from cohelm.cli.building import building
from cohelm.cli.drive import drive_building, drive_setup
from cohelm.cli.requests import BuildingRequest, DriveRequest
from cohelm.errors import CohelmError
from cohelm.live.floor_model import floor_model
from cohelm.maps.masks import read_mask, speed_limit_at

ROOMS = (("101", "Foyer"), ("201", "Ward 3"), ("301", "Pharmacy"))


@pytest.fixture(scope="module", params=["room", "element"])
def tower(request, tmp_path_factory):
    """Folder of a building whose lift is a room on each storey, or stands for itself on one."""
    folder = tmp_path_factory.mktemp("tower")
    model = lift_tower(marked=(request.param,), rooms=ROOMS).write(folder / "tower.ifc")
    building(BuildingRequest(model=model, out=folder))
    return folder


def test_every_storey_has_its_places_and_the_lifts_to_the_others(tower):
    found = drive_building(tower)
    assert [each.name for each in found.storeys] == ["Level 1", "Level 2", "Level 3"]
    assert [set(each.places) for each in found.storeys] == [{"Lift A", name} for _, name in ROOMS]
    assert found.storeys[1].lifts == {"Lift A": ("Level 1", "Level 3")}


@pytest.mark.parametrize(
    ("start", "storey"),
    [
        (None, "Level 1"),
        ("Pharmacy", "Level 3"),
        ("Lift A", "Level 1"),
        ("3,4", "Level 1"),
        ("lift a @ level 3", "Level 3"),
        ("Ward 3 @ 2", "Level 2"),
        ("3,4 @ Level 2", "Level 2"),
    ],
)
def test_the_drive_begins_on_the_storey_of_the_start(tower, start, storey):
    request = DriveRequest(scenario="empty", map=str(tower), start=start, people=0)
    with contextlib.ExitStack() as files:
        setup = drive_setup(request, files)
        there = drive_setup(replace(request, start="3,4,90"), files, storey="Level 2")
    assert setup.storey == storey
    assert (there.storey, there.scenario.start) == ("Level 2", (3.0, 4.0, 90.0))
    scene = floor_model(there.scenario, 0, there.storey, there.storeys).scene
    assert [each.lifts for each in scene.storeys] == [("Lift A",), (), ("Lift A",)]


def test_the_chair_is_slower_in_front_of_doors(tower):
    with contextlib.ExitStack() as files:
        setup = drive_setup(DriveRequest(scenario="empty", map=str(tower), people=0), files)
    (given,) = setup.scenario.filters
    masks = (read_mask(given.file, type=given.type),)
    limits = [speed_limit_at(masks, point, 1.0) for point in ([5.0, 2.5], [5.0, 4.5])]
    assert limits == [0.5, 1.0]  # the lift's door is at (5, 1.9)


def test_a_storey_that_is_not_there_is_named(tower):
    request = DriveRequest(scenario="empty", map=str(tower), start="Ward 3 @ Levl 2", people=0)
    mean = pytest.raises(CohelmError, match="no storey 'Levl 2'; did you mean 'Level 2'")
    with contextlib.ExitStack() as files, mean:
        drive_setup(request, files)


def test_a_folder_without_storeys_is_named(tmp_path):
    with contextlib.ExitStack() as files, pytest.raises(CohelmError, match="no storey"):
        drive_setup(DriveRequest(scenario="empty", map=str(tmp_path)), files)
