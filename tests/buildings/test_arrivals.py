"""Storeys on which a chair arrives by lifts, in authored models."""

import pytest
from tests.buildings.authored import lift_tower

from cohelm.buildings import accessibility, read_building
from cohelm.robots import Robot


def surveyed(author, folder, chair, entrance="Hall"):
    storeys = read_building(author.write(folder / "model.ifc"), resolution=0.05)
    return accessibility(storeys, chair, entrance)


def entrances(report):
    """Way to each room; empty if it is not reached."""
    return {room.name: room.entrance for room in report.rooms}


def tower(*spaces, **options):
    """Hall on Level 1, and rooms (name, low, high) on Level 2."""
    author = lift_tower(doors=(True, True), **options)
    first = author.storeys[0]
    author.box("IfcSpace", (0.2, 2.2, 0), (7.8, 5.8, 2.5), storey=first, Name="1", LongName="Hall")
    for number, (name, low, high) in enumerate(spaces):
        author.box("IfcSpace", (*low, 0), (*high, 2.5), Name=f"2{number}", LongName=name)
    return author


def wings():
    """West and East on Level 2 with a wall between, and a lift on each side of it."""
    author = tower(
        ("West", (0.2, 2.2), (5.9, 5.8)), ("East", (6.1, 2.2), (7.8, 5.8)), lifts=2
    )  # fmt: skip
    author.box("IfcWall", (5.9, 2, 0), (6.1, 5.8, 2.5))
    return author


def test_a_lift_leads_back_to_another_part_of_a_storey(tmp_path, chair):
    report = surveyed(wings(), tmp_path, chair, "West")
    assert entrances(report) == {
        "Hall": "West, lift Lift A", "West": "West", "East": "West, lift Lift A, lift Lift B",
    }  # fmt: skip
    assert report.barriers == ()


def test_of_two_lifts_the_one_that_is_too_small_is_the_barrier(tmp_path, chair):
    author = wings()
    for element in author.model.by_type("IfcTransportElement"):
        if element.Name == "Lift B":
            author.model.remove(element)
    author.box(
        "IfcTransportElement", (6.7, 0.8, 0), (7.3, 1.6, 2.2), storey=author.storeys[0],
        Name="Lift B",
    )  # fmt: skip
    report = surveyed(author, tmp_path, chair)
    assert entrances(report)["West"] == "Hall, lift Lift A"
    assert entrances(report)["East"] == ""
    assert [(each.fault.kind, each.place, each.opens) for each in report.barriers] == [
        ("lift", "lift Lift B", ("East, Level 2",))
    ]


@pytest.mark.parametrize("depth", [0.3, 1.6])
def test_a_lift_does_not_lead_through_the_wall_of_its_lobby(tmp_path, chair, depth):
    end = 2.0 + depth
    author = tower(("Lobby", (4, 2), (6, end)), ("Ward", (0.2, end + 0.1), (7.8, 5.8)))
    author.box("IfcWall", (0.2, end, 0), (7.8, end + 0.1, 2.5))
    author.box("IfcWall", (3.9, 0.2, 0), (4, end, 2.5))
    author.box("IfcWall", (6, 0.2, 0), (6.1, end, 2.5))
    report = surveyed(author, tmp_path, chair)
    lobby = "Hall, lift Lift A" if depth > 1.0 else ""
    assert entrances(report) == {"Hall": "Hall", "Lobby": lobby, "Ward": ""}


def test_furniture_in_front_of_a_lift_is_the_barrier(tmp_path, chair):
    author = tower(("Ward", (0.2, 2.2), (7.8, 5.8)))
    author.box("IfcWall", (3.9, 0.2, 0), (4, 2.2, 2.5))
    author.box("IfcWall", (6, 0.2, 0), (6.1, 2.2, 2.5))
    author.box("IfcFurniture", (3, 2.3, 0), (7, 3, 1.0))
    report = surveyed(author, tmp_path, chair, "Ward")
    assert entrances(report)["Hall"] == ""
    assert {(each.fault.kind, each.place) for each in report.barriers} == {("furniture", "Ward")}


@pytest.mark.parametrize("marked", [("element",), ("room",), ("room", "element")])
def test_a_chair_longer_than_the_car_does_not_fit_into_its_shaft(tmp_path, chair, marked):
    longer = tuple((1.3 * x, y) for x, y in chair.footprint)  # 1.44 m; car 1.2 m, shaft 1.6 m
    large = Robot.model_validate({**chair.model_dump(), "footprint": longer})
    author = tower(("Ward", (0.2, 2.2), (7.8, 5.8)), marked=marked)
    report = surveyed(author, tmp_path, large)
    assert (entrances(report)["Ward"] == "") == ("element" in marked)
    depths = [each for each in report.norms if each.rule.measure == "car depth"]
    assert [each.passes for each in depths] == [0, 0]
    assert [each.unknown for each in depths] == ([0, 0] if "element" in marked else [1, 1])
