"""``cohelm plan`` in a building: routes over storeys, directions, wishes, errors."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image
from tests.buildings.authored import Author, two_rooms, ward_block

from cohelm.cli.app import status


@pytest.fixture(scope="module")
def floors(tmp_path_factory):
    folder = tmp_path_factory.mktemp("block")
    model = ward_block().write(folder / "model.ifc")
    assert status(["building", str(model), "--out", str(folder / "floors")]) == 0
    return folder / "floors"


@pytest.fixture
def plan(capsys):
    def _plan(folder, start, goal, *options):
        code = status(["plan", str(folder), "--start", start, "--goal", goal, *map(str, options)])
        said = capsys.readouterr()
        return code, said.out if code == 0 else said.err

    return _plan


def test_the_lifts_of_each_storey_are_printed(floors, capsys):
    assert status(["building", str(floors.parent / "model.ifc")]) == 0
    said = capsys.readouterr().out
    assert "doors 4, Lift A to Level 2" in said
    assert "doors 3, Lift A to Level 1" in said


def test_a_route_to_another_storey_has_two_legs_and_directions(floors, plan, tmp_path):
    options = ("--avoid", "Store", "--json", "--plot", tmp_path / "route.png")
    code, said = plan(floors, "Foyer", "Ward 3", *options)
    assert code == 0
    report = json.loads(said)
    legs = report["legs"]
    assert [(leg["storey"], leg["from"], leg["to"]) for leg in legs] == [
        ("Level 1", "Foyer", "Lift A"), ("Level 2", "Lift A", "Ward 3"),
    ]  # fmt: skip
    assert report["length"] == pytest.approx(sum(leg["length"] for leg in legs))
    assert [step["text"] for step in report["directions"]][2:5] == [
        "Turn right and go along South Corridor for 11 m.", "Take the lift to Level 2.",
        "Turn right and go along North Corridor for 11 m.",
    ]  # fmt: skip
    assert report["wishes"].keys() == {"avoid"}
    for file in report["written"]:
        assert np.array(Image.open(file)).std() > 10.0
    # Paths go through the doors of the directions: A0 from x = 2 to 3, at y = 3.9.
    points = np.array(legs[0]["points"])
    crossing = points[np.argmin(np.abs(points[:, 1] - 3.9))]
    assert 2.0 < crossing[0] < 3.0


def test_the_path_follows_the_directions_where_another_door_is_as_near(floors, plan):
    code, said = plan(floors, "Foyer", "Ward 3", "--json")
    assert code == 0
    report = json.loads(said)
    rooms = [step["room"] for step in report["directions"] if step["kind"] == "door"]
    points = np.array(report["legs"][0]["points"])
    assert ("Store" in rooms) == bool(points[points[:, 1] < 3.8][:, 0].max() > 5.0)


def test_the_price_of_a_wish_is_the_difference_of_the_driven_paths(tmp_path, plan, capsys):
    model = ward_block(narrow=1.0).write(tmp_path / "model.ifc")
    assert status(["building", str(model), "--out", str(tmp_path / "floors")]) == 0
    capsys.readouterr()
    ends = tmp_path / "floors", "Store", "Lift A @ 1", "--json"
    plain, avoiding = (json.loads(plan(*ends, *o)[1]) for o in ((), ("--avoid", "South Corridor")))
    assert plain["wishes"] == {}
    price = avoiding["length"] - plain["length"]
    assert avoiding["wishes"] == {"avoid": pytest.approx(price)}
    wide = json.loads(plan(*ends, "--prefer", "wide")[1])
    assert wide["wishes"] == {"wide": pytest.approx(wide["length"] - plain["length"])}


def test_places_added_to_the_file_of_a_storey_are_destinations(floors, plan, tmp_path):
    folder = shutil.copytree(floors, tmp_path / "floors")
    with (folder / "level-2.places.yaml").open("a", encoding="utf-8") as file:
        file.write("Printer: {point: [14.0, 4.5], names: {de: Drucker}}\nPipe: [5.0, 3.9]\n")
    code, said = plan(folder, "Foyer", "Printer")
    assert code == 0
    assert "You are at Printer." in said
    assert "'Pipe' on Level 2 lies on no free floor" in said
    code, said = plan(folder, "drucker @ 2", "Ward 3", "--json")
    assert json.loads(said)["legs"][0]["points"][0] == pytest.approx([14.0, 4.5], abs=0.01)
    code, said = plan(folder, "Foyer", "Pipe")
    assert code == 2
    assert "'Pipe' on Level 2 lies on no free floor" in said


def test_places_go_by_number_and_storey(floors, plan):
    code, said = plan(floors, "A1", "radiology @ Level 2")
    assert code == 0
    assert "You are at Radiology." in said


def test_a_goal_at_the_start_needs_no_leg(floors, plan):
    code, said = plan(floors, "Foyer", "Foyer", "--json")
    assert code == 0
    report = json.loads(said)
    assert (report["legs"], report["length"]) == ([], 0.0)
    assert [step["kind"] for step in report["directions"]] == ["start", "arrive"]


def test_one_storey_is_one_leg(floors, plan):
    code, said = plan(floors, "Foyer", "Store", "--json")
    assert code == 0
    assert len(json.loads(said)["legs"]) == 1


@pytest.mark.parametrize(
    ("goal", "options", "problem"),
    [
        ("Wardd", (), "--goal: no place 'Wardd'; did you mean 'Ward 3'?"),
        ("Lift A", (), "--goal: 'Lift A' may be 'Lift A @ Level 1' or 'Lift A @ Level 2'"),
        ("Ward 3", ("--prefer", "1,2"), "--prefer: in a building write wide or level"),
        ("Ward 3", ("--avoid", "Nowhere"), "--avoid: no room 'Nowhere'"),
        ("Ward 3", ("--alternatives", "3"), "--alternatives: needs one map"),
        ("Ward 3", ("--avoid-hard", "South Corridor"), "rooms never to enter close every way"),
        ("Ward 3", ("--clearance", "0.4"), "too narrow is the door"),
    ],
)
def test_what_is_wrong_is_one_line(floors, plan, goal, options, problem):
    code, said = plan(floors, "Foyer", goal, *options)
    assert code == 2
    assert said.startswith("error: ")
    assert said.count("\n") == 1
    assert problem in said


def test_a_folder_without_a_building_is_one_line(plan, tmp_path):
    code, said = plan(tmp_path, "A", "B")
    assert (code, said.count("\n")) == (2, 1)
    assert "no storey" in said


@pytest.mark.parametrize("height", [0.02, 0.2])
def test_a_threshold_that_the_chair_does_not_climb_closes_a_door(plan, tmp_path, height):
    author, _ = two_rooms()
    door = next(each for each in author.model.by_type("IfcDoor") if each.Name == "D1")
    lining = author.root("IfcDoorLiningProperties", ThresholdThickness=height)
    author.root(
        "IfcRelDefinesByProperties", RelatedObjects=[door], RelatingPropertyDefinition=lining
    )
    model = author.write(tmp_path / "m.ifc")
    assert status(["building", str(model), "--out", str(tmp_path)]) == 0
    code, said = plan(tmp_path, "Office", "Ward 3")
    assert code == (0 if height < 0.1 else 2)
    if code:
        assert said.count("\n") == 1
        assert "the threshold of the door 'D1' (Office – Ward 3), 0.90 m wide" in said
        assert said.rstrip().endswith("is 0.200 m high")


def test_where_the_chair_cannot_turn_the_door_is_named_or_avoided(plan, tmp_path):
    author = Author()
    author.storey("Ground Floor")
    author.box("IfcSlab", (0, 0, -0.2), (8, 4, 0.0))
    for low, high in (
        ((0, 0), (8, 0.2)), ((0, 3.8), (8, 4)), ((0, 0.2), (0.2, 3.8)), ((7.8, 0.2), (8, 3.8)),
        ((1.05, 1.0), (1.25, 3.8)),
    ):  # fmt: skip
        author.box("IfcWall", (*low, 0), (*high, 2.5))
    wall = author.box("IfcWall", (0.2, 1.0, 0), (1.05, 1.2, 2.5))
    author.door(wall, (0.28, 1.0, 0), (0.97, 1.2, 2.1), Name="N")
    author.box("IfcWall", (1.05, 0.9, 0), (1.25, 1.0, 2.5))
    author.box("IfcSpace", (0.2, 1.2, 0), (1.05, 3.8, 2.5), Name="1", LongName="Closet")
    author.box("IfcSpace", (1.25, 0.2, 0), (7.8, 3.8, 2.5), Name="2", LongName="Hall")
    assert status(
        ["building", str(author.write(tmp_path / "m.ifc")), "--out", str(tmp_path)]
    ) == 0  # fmt: skip
    code, said = plan(tmp_path, "Hall", "Closet")
    assert code == 2
    assert "the robot does not get through the door 'N' (" in said
    assert said.count("\n") == 1


def test_a_room_s_name_is_a_zone_on_one_map(floors, plan):
    options = ("--avoid-hard", "South Corridor")
    code, said = plan(floors / "level-1.yaml", "Foyer", "Store", *options)
    assert code == 0
    assert "kept" in said
    code, said = plan(floors / "level-1.yaml", "Foyer", "Store", "--avoid", "Stor")
    assert code == 2
    assert "did you mean 'Store'?" in said
