"""Rooms that a chair reaches, and barriers to the others, in authored and open models."""

import numpy as np
import pytest
from scipy import ndimage
from tests.buildings.authored import Author, lift_tower, two_rooms

from cohelm.buildings import accessibility, read_building, write_storey
from cohelm.buildings.norms import MeasuredValue, check_norms
from cohelm.errors import ConfigError
from cohelm.geometry import resample, transform
from cohelm.maps import distance_field
from cohelm.robots import Robot

FINE = 0.025


@pytest.fixture
def width(chair):
    return float(np.ptp(chair.outline[:, 1]))


def surveyed(author, folder, chair, entrance=None, resolution=FINE):
    storeys = read_building(author.write(folder / "model.ifc"), resolution=resolution)
    return accessibility(storeys, chair, entrance)


def reached(report):
    return {room.name: room.path is not None for room in report.rooms}


def faults(report, name):
    """Sets of (kind, place) that keep the chair out of a room."""
    room = next(each for each in report.rooms if each.name == name)
    by_number = {each.number: each for each in report.barriers}
    return [
        {(by_number[n].fault.kind, by_number[n].place.split(" (")[0]) for n in numbers}
        for numbers in room.barriers
    ]


def test_a_door_two_centimetres_too_narrow_is_the_barrier(tmp_path, chair, width):
    author, _ = two_rooms(door=width - 0.02)
    report = surveyed(author, tmp_path, chair)
    assert reached(report) == {"Office": True, "Ward 3": False}
    assert faults(report, "Ward 3") == [{("width", "door D1")}]
    (barrier,) = report.barriers
    assert "0.02 m too narrow" in barrier.text
    assert f"needs {width:.2f} m" in barrier.text
    assert barrier.opens == ("Ward 3",)
    assert report.summary == "1 of 2 rooms are reached."


@pytest.mark.parametrize("source", ["model", "map"])
@pytest.mark.parametrize(("margin", "open_"), [(-0.02, False), (0.1, True)])
def test_a_door_wider_by_ten_centimetres_is_open(tmp_path, chair, width, source, margin, open_):
    author, _ = two_rooms(door=width + margin)
    storeys = read_building(author.write(tmp_path / "model.ifc"), resolution=FINE)
    if source == "map":
        write_storey(storeys[0], tmp_path)
        storeys = read_building(tmp_path / "ground-floor.yaml")
    report = accessibility(storeys, chair, "Office")
    assert reached(report)["Office"]
    assert reached(report).get("Ward 3", False) is open_


def test_the_entrance_itself_may_be_the_barrier(tmp_path, chair, width):
    author, _ = two_rooms(door=1.0)
    south = next(each for each in author.model.by_type("IfcDoor") if each.Name == "D0")
    lining = author.root("IfcDoorLiningProperties", LiningThickness=(1.0 - width + 0.03) / 2.0)
    author.root(
        "IfcRelDefinesByProperties", RelatedObjects=[south], RelatingPropertyDefinition=lining
    )
    report = surveyed(author, tmp_path, chair)
    assert not any(reached(report).values())
    (barrier,) = report.barriers
    assert barrier.fault.kind == "width"
    assert set(barrier.opens) == {"Office", "Ward 3"}


def row_of_rooms(widths, threshold=None):
    """Rooms of 3 × 3 m in a row, from the front door on, with doors of some widths between."""
    author = Author()
    author.storey("Ground Floor")
    ends = 0.2 + 3.2 * (len(widths) + 1)
    author.box("IfcSlab", (0, 0, -0.2), (ends, 3.4, 0))
    author.box("IfcWall", (0, 3.2, 0), (ends, 3.4, 2.5))
    south = author.box("IfcWall", (0, 0, 0), (ends, 0.2, 2.5))
    author.door(south, (1.0, 0, 0), (2.2, 0.2, 2.1), Name="front")
    for i in range(len(widths) + 2):
        x = 3.2 * i
        wall = author.box("IfcWall", (x, 0.2, 0), (x + 0.2, 3.2, 2.5))
        if 0 < i <= len(widths) and widths[i - 1]:
            top = 1.2 + widths[i - 1]
            author.door(wall, (x, 1.2, 0), (x + 0.2, top, 2.1), along=1, Name=f"D{i}")
        if i <= len(widths):
            author.box(
                "IfcSpace", (x + 0.2, 0.2, 0), (x + 3.2, 3.2, 2.5), Name=str(i), LongName=f"R{i}"
            )
    if threshold:
        door = next(each for each in author.model.by_type("IfcDoor") if each.Name == "D1")
        lining = author.root("IfcDoorLiningProperties", ThresholdThickness=threshold)
        author.root(
            "IfcRelDefinesByProperties", RelatedObjects=[door], RelatingPropertyDefinition=lining
        )
    return author


def test_two_blocked_doors_in_series_are_named_together(tmp_path, chair):
    report = surveyed(row_of_rooms([0.5, 0.55, 1.0]), tmp_path, chair)
    assert reached(report) == {"R0": True, "R1": False, "R2": False, "R3": False}
    assert faults(report, "R1") == [{("width", "door D1")}]
    for room in ("R2", "R3"):
        assert faults(report, room) == [{("width", "door D1"), ("width", "door D2")}]
    assert [barrier.opens for barrier in report.barriers] == [("R1",), ()]
    assert report.barriers[1].shares == ("R2", "R3")


def test_a_threshold_is_compared_with_what_the_chair_climbs(tmp_path, chair):
    for height, passes in ((chair.max_step_up - 0.01, True), (chair.max_step_up + 0.01, False)):
        report = surveyed(row_of_rooms([1.0], height), tmp_path, chair)
        assert reached(report)["R1"] is passes
    assert faults(report, "R1") == [{("threshold", "door D1")}]
    check = next(each for each in report.norms if each.rule.clause == "404.2.5")
    (failure,) = check.failures
    assert failure.startswith("door D1 (")
    assert failure.endswith(f": {chair.max_step_up + 0.01:.3f} m")


def test_a_room_without_a_door_and_one_full_of_furniture(tmp_path, chair):
    author = row_of_rooms([1.0, 0.0])
    author.box("IfcFurniture", (3.6, 0.3, 0), (6.3, 3.1, 1.0))
    report = surveyed(author, tmp_path, chair)
    assert faults(report, "R1") == [{("furniture", "R1")}]
    assert next(r.remark for r in report.rooms if r.name == "R2") == "no door leads to it"


def test_an_opening_without_a_door_is_compared_with_the_norms_of_doors(tmp_path, chair):
    author = row_of_rooms([0.0])
    wall = author.box("IfcWall", (6.6, 0.2, 0), (6.8, 3.2, 2.5))
    author.opening(wall, (6.6, 1, 0), (6.8, 1.7, 2.1))
    report = surveyed(author, tmp_path, chair)
    checks = {each.rule.measure: each for each in report.norms if each.rule.norm.startswith("2010")}
    (failure,) = checks["door"].failures
    assert failure.endswith(": 0.700 m")
    counts = {
        name: checks[name].passes + checks[name].unknown + len(checks[name].failures)
        for name in ("door", "approach", "threshold")
    }
    assert counts == {"door": 2, "approach": 2, "threshold": 1}


@pytest.mark.slow
def test_a_door_may_be_wide_enough_but_the_turn_too_tight(tmp_path, chair, width):
    author = row_of_rooms([width + 0.1])
    author.box("IfcFurniture", (0.2, 1.0, 0), (2.35, 3.2, 1.0))  # leaves 0.8 m before the door
    report = surveyed(author, tmp_path, chair, resolution=0.05)
    assert not reached(report)["R1"]
    kinds = {kind for each in faults(report, "R1") for kind, _ in each}
    assert kinds <= {"turn", "furniture", "space"}
    assert kinds & {"turn", "furniture"}


def test_a_storey_that_only_stairs_lead_to(tmp_path, chair):
    author, _ = two_rooms()
    author.box("IfcStairFlight", (5, 2, 0), (7, 3, 1.5), Name="Stair 1")
    author.storey("First Floor", 3.0)
    author.box("IfcSlab", (0, 0, -0.2), (7.6, 3.4, 0.0))
    author.box("IfcSpace", (0.2, 0.2, 0), (7.4, 3.2, 2.5), Name="201", LongName="Attic")
    report = surveyed(author, tmp_path, chair)
    assert reached(report)["Attic"] is False
    assert faults(report, "Attic") == [{("stairs", "Ground Floor to First Floor")}]


@pytest.mark.parametrize("marked", [("element",), ("room", "element")])
def test_a_lift_leads_to_other_storeys(tmp_path, chair, marked):
    rooms = [("1", "Hall"), ("2", "Office"), ("3", "Ward")]
    author = lift_tower(rooms=rooms, marked=marked)
    report = surveyed(author, tmp_path, chair, "Hall", resolution=0.05)
    halls = {room.name: room for room in report.rooms if room.name in dict(rooms).values()}
    assert all(room.path is not None for room in halls.values())
    assert halls["Office"].entrance == "Hall, lift Lift A"
    assert halls["Office"].length > 0.0
    assert {each.rule.clause for each in report.norms} >= {"407.4.1"}


def test_a_lift_that_is_too_small_is_named(tmp_path, chair):
    longer = tuple((1.6 * x, y) for x, y in chair.footprint)
    large = Robot.model_validate({**chair.model_dump(), "footprint": longer})
    author = lift_tower(rooms=[("1", "Hall"), ("2", "Office"), ("3", "Ward")])
    report = surveyed(author, tmp_path, large, "Hall", resolution=0.05)
    assert faults(report, "Office") == [{("lift", "lift Lift A")}]


def test_an_entrance_is_a_room_a_door_or_a_point(tmp_path, chair):
    author, _ = two_rooms()
    storeys = read_building(author.write(tmp_path / "model.ifc"))
    door = next(each.id for each in storeys[0].doors if each.name == "D0")
    for entrance in ("ward 3", "102", "D0", door, "1,1", "Ground Floor: Office", "1: 102"):
        assert all(reached(accessibility(storeys, chair, entrance)).values()), entrance
    for entrance, problem in (
        ("Kitchen", "no room or door 'Kitchen'; known: Office, Ward 3"),
        ("0.1,0.1", "does not fit"),
        ("99,99", "does not fit"),
    ):
        with pytest.raises(ConfigError, match=problem):
            accessibility(storeys, chair, entrance)
    lower, upper = two_rooms()[0], "First Floor"
    lower.storey(upper, 3.0)
    lower.box("IfcSlab", (0, 0, -0.2), (7.6, 3.4, 0.0))
    lower.box("IfcSpace", (0.2, 0.2, 0), (7.4, 3.2, 2.5), Name="201", LongName="Office")
    storeys = read_building(lower.write(tmp_path / "model.ifc"))
    with pytest.raises(ConfigError, match="ambiguous: 'Ground Floor: Office', 'First Floor: Off"):
        accessibility(storeys, chair, "Office")


def collides(grid, outline, pose):
    """True if points in the footprint, 1 cm apart and 1 cm inside, lie in blocked cells."""
    low, high = outline.min(axis=0) + 0.01, outline.max(axis=0) - 0.01
    points = np.stack(np.meshgrid(*(np.arange(a, b, 0.01) for a, b in zip(low, high, strict=True))))
    cells = grid.cells(transform(pose, points.reshape(2, -1).T))
    return grid.blocked()[tuple(cells.T)].any()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["AC11-FZK-Haus", "SampleHouse_IFC4"])
def test_every_path_is_free_and_agrees_with_a_flood_fill(data, chair, name):
    storeys = read_building(data / "ifc" / f"{name}.ifc")
    inside = next(room.name for room in storeys[0].rooms if room.area > 10.0)
    report = accessibility(storeys, chair, inside or None)
    grid = storeys[0].grid  # without landings: the way begins in a room
    clear = distance_field(grid).distance > chair.inscribed_radius
    labels, _ = ndimage.label(clear, np.ones((3, 3)))
    found = [room for room in report.rooms if room.path is not None]
    assert len(found) > 2
    for room in found:
        start, end = (labels[tuple(grid.cells(p))] for p in room.path[[0, -1]])
        assert start == end > 0
        for a, b in zip(room.path[:-1], room.path[1:], strict=True):
            if np.hypot(*(b - a)) < 1e-9:
                continue
            angle = np.arctan2(*(b - a)[::-1])
            for point in resample(np.array([a, b]), 0.05):
                forward, backward = (
                    collides(grid, chair.outline, np.array([*point, angle + turn]))
                    for turn in (0.0, np.pi)
                )
                assert not (forward and backward), (room.name, point)


def test_norms_pass_fail_or_stay_unknown():
    values = [("a", 0.8128), ("b", 0.79), ("c", None)]
    checks = {
        (check.rule.clause, check.rule.measure): (check.passes, len(check.failures), check.unknown)
        for check in check_norms(
            {
                "door": [MeasuredValue(*each) for each in values],  # 0.8128 m are 32 inches
                "turning": [MeasuredValue("hall", 1.45, 0.1), MeasuredValue("closet", 1.3, 0.1)],
                "approach": [MeasuredValue("d", 1.2), MeasuredValue("e", 1.0)],
                "route": [MeasuredValue(f"{v} m", v) for v in (0.8, 0.82, 0.91, 0.92)],
                "ramp": [MeasuredValue("ramp", None)],
            }
        )
    }
    assert checks["404.2.3", "door"] == (1, 1, 1)
    assert checks["304.3.1", "turning"] == (0, 1, 1)
    assert checks["404.2.4", "approach"] == (0, 1, 1)
    assert checks["403.5.1", "route"] == (1, 1, 2)
    assert checks["405.2", "ramp"] == (0, 0, 1)
    assert ("407.4.1", "car width") not in checks
