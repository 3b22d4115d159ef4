"""Storeys of IFC models: authored ones with known numbers, and four open models."""

import ifcopenshell
import numpy as np
import pytest
from tests.buildings.authored import Author, two_rooms

from cohelm.buildings import read_building, room_names
from cohelm.errors import BuildingError


def the_storey(author, folder, **options):
    (storey,) = read_building(author.write(folder / "model.ifc"), **options)
    return storey


def free_width(grid, door):
    """Length of the free cells across a doorway, m."""
    along = np.arange(-1.5, 1.5, grid.resolution / 10.0)
    points = door.point + along[:, None] * door.direction
    rows, cols = grid.cells(points).T
    return np.count_nonzero(grid.data[rows, cols] == 0) * grid.resolution / 10.0


@pytest.mark.parametrize("turned", [0.0, 0.4])
@pytest.mark.parametrize(("schema", "unit"), [("IFC4", 0.001), ("IFC2X3", 1.0), ("IFC4X3", 0.3048)])
def test_rooms_doors_and_widths_are_those_of_the_model(tmp_path, schema, unit, turned):
    author, _ = two_rooms(schema=schema, unit=unit, turned=turned, at=(20.0, -5.0, 0.0))
    storey = the_storey(author, tmp_path)
    assert storey.elevation == pytest.approx(0.0, abs=1e-6)
    assert [*room_names(storey.rooms).values()] == ["Office", "Ward 3"]
    assert [room.number for room in storey.rooms] == ["101", "102"]
    assert [room.area for room in storey.rooms] == pytest.approx([12.0, 9.0], rel=0.01)
    office, ward = (room.id for room in storey.rooms)
    doors = {door.name: door for door in storey.doors}
    assert set(doors["D1"].rooms) == {office, ward}
    assert doors["D0"].rooms == (office,)
    assert doors["D1"].width == pytest.approx(0.9, abs=0.01)
    assert doors["D0"].width == pytest.approx(1.0, abs=0.01)
    assert doors["D1"].depth == pytest.approx(0.2, abs=0.01)
    # The door's middle is (4.3, 1.45) in the building.
    cos, sin = np.cos(turned), np.sin(turned)
    at = [20.0 + cos * 4.3 - sin * 1.45, -5.0 + sin * 4.3 + cos * 1.45]
    assert doors["D1"].point == pytest.approx(at, abs=0.01)
    assert abs(doors["D1"].direction @ [-sin, cos]) == pytest.approx(1.0)
    assert storey.notes == ()


@pytest.mark.parametrize("offset", [0.0, 0.013, 0.03])
def test_the_map_is_no_wider_than_the_building_and_two_cells_narrower(tmp_path, offset):
    author, _ = two_rooms(at=(offset, offset, 0.0))
    storey = the_storey(author, tmp_path)
    door = next(door for door in storey.doors if door.name == "D1")
    assert 0.9 - 2 * 0.05 - 0.01 <= free_width(storey.grid, door) <= 0.9 + 0.01


def test_a_lining_narrows_the_door_and_the_map(tmp_path):
    author, _ = two_rooms(door=1.0, lining=0.1)
    storey = the_storey(author, tmp_path)
    door = next(door for door in storey.doors if door.name == "D1")
    assert door.width == pytest.approx(0.8, abs=0.01)
    assert door.width_from == "opening less lining"
    assert 0.7 <= free_width(storey.grid, door) <= 0.81


def test_rooms_come_from_the_free_floor_where_there_are_no_spaces(tmp_path):
    author, _ = two_rooms(spaces=False, slab=False)
    storey = the_storey(author, tmp_path)
    assert [room.area for room in storey.rooms] == pytest.approx([12.0, 9.0], rel=0.05)
    assert sorted(len(door.rooms) for door in storey.doors) == [1, 2]
    assert len(storey.notes) == 2
    assert "walls enclose" in storey.notes[0]
    assert "no spaces" in storey.notes[1]


def occupied(storey, x, y):
    row, col = storey.grid.cells([x, y])
    return storey.grid.data[row, col] == 100


def test_the_band_decides_what_is_in_the_way(tmp_path):
    author, _ = two_rooms()
    author.box("IfcFurniture", (1.0, 1.0, 0.0), (1.5, 1.5, 0.04))  # a mat
    author.box("IfcFurniture", (2.0, 1.0, 0.7), (2.5, 1.5, 0.75))  # a table's plate
    author.box("IfcFurniture", (3.0, 1.0, 1.3), (3.5, 1.5, 1.6))  # a shelf on the wall
    author.box("IfcRailing", (1.0, 2.0, 0.0), (3.0, 2.012, 1.0))  # 12 mm thick
    storey = the_storey(author, tmp_path)
    assert [occupied(storey, x, 1.25) for x in (1.25, 2.25, 3.25)] == [False, True, False]
    assert all(occupied(storey, x, 2.006) for x in np.arange(1.0, 3.0, 0.05))


def test_a_wall_of_another_storey_that_reaches_up_is_an_obstacle(tmp_path):
    author, _ = two_rooms()
    author.box("IfcColumn", (1.0, 1.0, -1.0), (1.5, 1.5, 6.0))
    author.storey("First Floor", 3.0)
    author.box("IfcSlab", (0, 0, -0.2), (7.6, 3.4, 0.0))
    _, first = read_building(author.write(tmp_path / "model.ifc"))
    assert occupied(first, 1.25, 1.25)
    assert not occupied(first, 2.25, 1.25)


def test_an_opening_without_a_door_joins_rooms_and_a_niche_does_not(tmp_path):
    author, _ = two_rooms()
    middle = next(each for each in author.model.by_type("IfcWall") if each.Name == "middle")
    author.opening(middle, (4.2, 2.2, 0), (4.4, 3.0, 2.2))
    author.opening(middle, (4.2, 0.2, 0), (4.3, 0.9, 2.2))
    storey = the_storey(author, tmp_path)
    (opening,) = (door for door in storey.doors if door.kind == "opening")
    assert opening.width == pytest.approx(0.8, abs=0.01)
    assert len(opening.rooms) == 2


def test_rooms_without_a_wall_between_share_an_open_border(tmp_path):
    author = Author()
    author.storey("Hall")
    author.box("IfcSlab", (0, 0, -0.2), (6, 3, 0))
    for x in (0, 3):
        author.box("IfcSpace", (x, 0, 0), (x + 3, 3, 2.5), Name=f"{x}")
    author.box("IfcWall", (2.9, 0, 0), (3.1, 1, 2.5))
    storey = the_storey(author, tmp_path)
    (border,) = storey.doors
    assert border.kind == "open border"
    assert border.width == pytest.approx(2.0, abs=0.05)


def test_storeys_at_one_height_are_joined_and_a_wrong_elevation_is_noted(tmp_path):
    author, _ = two_rooms()
    author.storey("Annex", 0.0, elevation=1.0)
    author.box("IfcSpace", (10, 0, 0), (12, 2, 2.5), Name="201", LongName="Store")
    storey = the_storey(author, tmp_path)
    assert storey.name == "Ground Floor / Annex"
    assert len(storey.rooms) == 3
    assert "one height" in storey.notes[0]
    assert "Elevation 1.00 m" in storey.notes[1]
    assert "no slab below Store" in " ".join(storey.notes) or "no slab" in " ".join(storey.notes)


def test_a_door_in_the_wrong_storey_changes_over(tmp_path):
    author, ground = two_rooms()
    author.storey("First Floor", 3.0)
    author.box("IfcSlab", (0, 0, -0.2), (7.6, 3.4, 0.0))
    wall = author.box("IfcWall", (4, 0, 0), (4.2, 3.4, 2.5))
    author.opening(wall, (4, 1, 0), (4.2, 2, 2.1))
    author.box("IfcDoor", (4, 1, 3), (4.2, 2, 5.1), storey=ground, Name="lost", OverallWidth=1.0)
    below, above = read_building(author.write(tmp_path / "model.ifc"))
    assert "lost" not in {door.name for door in below.doors}
    assert "lost" in {door.name for door in above.doors}
    assert "by its height" in " ".join(above.notes)


def test_lifts_and_stairs_have_outlines(tmp_path):
    author, _ = two_rooms()
    author.box("IfcTransportElement", (0.4, 2.0, 0), (1.4, 3.0, 2.2), Name="Lift 1")
    author.box("IfcStairFlight", (5, 2, 0), (7, 3, 1.5), Name="Stair 1")
    storey = the_storey(author, tmp_path)
    assert {(link.kind, link.name) for link in storey.links} == {
        ("lift", "Lift 1"),
        ("stairs", "Stair 1"),
    }
    lift = next(link for link in storey.links if link.kind == "lift")
    assert lift.polygon.min(axis=0) == pytest.approx([0.4, 2.0])
    assert lift.polygon.max(axis=0) == pytest.approx([1.4, 3.0])


def test_a_storey_is_chosen_by_name_or_number(tmp_path):
    author, _ = two_rooms()
    author.storey("First Floor", 3.0)
    author.box("IfcSlab", (0, 0, -0.2), (7.6, 3.4, 0.0))
    file = author.write(tmp_path / "model.ifc")
    assert [(s.number, s.name) for s in read_building(file, storey="2")] == [(2, "First Floor")]
    assert [s.name for s in read_building(file, storey="ground floor")] == ["Ground Floor"]
    with pytest.raises(BuildingError, match="no storey '3': there are 1 'Ground Floor'"):
        read_building(file, storey="3")


OPEN_MODELS = {
    "AC11-FZK-Haus": {"Erdgeschoss": (6, 5), "Dachgeschoss": (1, 0)},
    "Duplex_Architecture_2x3": {
        "T/FDN": (0, 0),
        "Level 1": (10, 6),
        "Level 2": (10, 8),
        "Roof": (1, 0),
    },
    "SampleHouse_IFC4": {"Ground Floor": (3, 3), "Roof": (1, 0)},
    "bimwhale_LargeBuilding": {"Level 1": (8, 18), "Level 2": (1, 0)},
}
"""Rooms and doors of each storey: the spaces and doors of the model, at their heights. Level 2 of
the last one has no spaces: its free floor is one room."""


def said_by_boundaries(file):
    """Spaces that the boundaries of a model give each door."""
    said = {}
    for boundary in ifcopenshell.open(str(file)).by_type("IfcRelSpaceBoundary"):
        element = boundary.RelatedBuildingElement
        if element is not None and element.is_a("IfcDoor"):
            said.setdefault(element.GlobalId, set()).add(boundary.RelatingSpace.GlobalId)
    return said


@pytest.mark.parametrize("name", OPEN_MODELS)
def test_an_open_model_has_all_its_rooms_and_doors(data, name):
    file = data / "ifc" / f"{name}.ifc"
    storeys = read_building(file)
    doors = {s.name: [door for door in s.doors if door.kind == "door"] for s in storeys}
    counts = {storey.name: (len(storey.rooms), len(doors[storey.name])) for storey in storeys}
    assert counts == OPEN_MODELS[name]
    said = said_by_boundaries(file)
    if said:
        found = {door.id: set(door.rooms) for on in doors.values() for door in on}
        assert found.keys() == said.keys()
        # A boundary may name a third space that only touches the wall beside the door.
        assert all(found[door] == said[door] for door in said if len(said[door]) <= 2)
        assert all(found[door] <= said[door] for door in said)
