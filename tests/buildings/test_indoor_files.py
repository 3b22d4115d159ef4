"""IndoorGML and osmAG: authored files with known rooms, and the stored samples."""

import numpy as np
import pytest

from cohelm.buildings import lifts_of, read_building, route_graph
from cohelm.errors import BuildingError

CELL = """<core:cellSpaceMember><core:CellSpace gml:id="{0}"><gml:description>storey="{1}"
</gml:description><gml:name>{0}</gml:name><core:cellSpaceGeometry><core:Geometry3D><gml:Solid>
<gml:LinearRing>{2}</gml:LinearRing></gml:Solid></core:Geometry3D></core:cellSpaceGeometry>
</core:CellSpace></core:cellSpaceMember>"""
GML = """<core:IndoorFeatures xmlns:gml="http://www.opengis.net/gml/3.2"
xmlns:core="http://www.opengis.net/indoorgml/1.0/core">{0}</core:IndoorFeatures>"""


def cell(name, low, high, storey="F1", z=0.0):
    (x0, y0), (x1, y1) = low, high
    ring = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
    return CELL.format(name, storey, "".join(f"<gml:pos>{x} {y} {z}</gml:pos>" for x, y in ring))


def gml(folder, *cells):
    file = folder / "floor.gml"
    file.write_text(GML.format("".join(cells)), encoding="utf-8")
    return file


def osm(folder, ways, to_degrees=1.0 / 111_319.49):
    """An osmAG file of ways (tags, corners in metres) near latitude and longitude 0."""
    nodes, lines = [], []
    for tags, corners in ways:
        refs = range(len(nodes), len(nodes) + len(corners))
        nodes += [
            f'<node id="{i}" lat="{y * to_degrees}" lon="{x * to_degrees}"/>'
            for i, (x, y) in zip(refs, corners, strict=True)
        ]
        nds = "".join(f'<nd ref="{i}"/>' for i in refs)
        marks = "".join(f'<tag k="{k}" v="{v}"/>' for k, v in tags.items())
        lines.append(f'<way id="w{len(lines)}">{nds}{marks}</way>')
    file = folder / "floor.osm"
    file.write_text(f"<osm>{''.join(nodes + lines)}</osm>", encoding="utf-8")
    return file


def square(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]


def test_cells_of_indoor_gml_are_rooms_and_doors(tmp_path):
    file = gml(
        tmp_path, cell("Office", (0, 0), (4, 3)), cell("Ward", (4.2, 0), (8.2, 3)),
        cell("Door1", (4, 1), (4.2, 1.9)), cell("Outdoor", (0, 0), (4, 3), "F2", 3.0),
    )  # fmt: skip
    first, second = read_building(file)
    assert [(s.name, s.number, s.elevation) for s in (first, second)] == [
        ("F1", 1, 0.0), ("F2", 2, 3.0),
    ]  # fmt: skip
    assert [room.name for room in first.rooms] == ["Office", "Ward"]
    assert [room.area for room in first.rooms] == pytest.approx([12.0, 12.0])
    (door,) = first.doors
    assert set(door.rooms) == {"Office", "Ward"}
    assert (door.width, door.depth) == (pytest.approx(0.9), pytest.approx(0.2))
    assert door.point == pytest.approx([4.1, 1.45])
    graph = route_graph([first, second])
    route = graph.route(graph.find("Office"), graph.find("Ward"))
    assert 0.9 - 0.11 <= route.clear_width <= 0.91
    assert read_building(file, storey="f2")[0].rooms[0].name == "Outdoor"
    with pytest.raises(BuildingError, match="no storey '3': there are F1, F2"):
        read_building(file, storey="3")


def test_areas_and_passages_of_osm_ag_are_rooms_and_doors(tmp_path):
    area = {"osmAG:type": "area", "osmAG:areaType": "room"}
    ways = [
        ({**area, "name": "Kitchen"}, square(0, 0, 4, 3)),
        ({**area, "name": "Hall"}, square(4, 0, 9, 3)),
        ({"osmAG:type": "passage", "name": "p"}, [(4, 1), (4, 2)]),
        ({"osmAG:furniture_type": "oven"}, square(0, 2.4, 1, 3)),
        ({"building": "yes"}, square(-50, -50, 50, 50)),
    ]
    (storey,) = read_building(osm(tmp_path, ways))
    assert [room.name for room in storey.rooms] == ["Kitchen", "Hall"]
    assert [room.area for room in storey.rooms] == pytest.approx([12.0, 15.0], rel=1e-3)
    (door,) = storey.doors
    assert (len(door.rooms), door.width) == (2, pytest.approx(1.0, rel=1e-3))
    kitchen = storey.rooms[0].polygons[0]
    oven = storey.grid.cells(kitchen.min(axis=0) + np.array([0.5, 2.7]))
    assert storey.grid.data[tuple(oven)] == 100
    graph = route_graph([storey])
    assert graph.route(graph.find("Kitchen"), graph.find("Hall"), width=0.8).length > 3.0


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("a.gml", "<a", "cannot be read"),
        ("a.gml", "<a/>", "no room with an outline: IndoorGML needs the geometry"),
        ("a.osm", '<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "document type"),
        ("a.osm", '<osm><way id="1"><nd ref="2"/></way></osm>', "cannot be read"),
        ("a.gml", GML.format(cell("A", (0, 0), (0, 0)) + cell("B", (0, 0), (4, 3), z="x")), "'x'"),
    ],
)
def test_what_cannot_be_read_is_one_sentence(tmp_path, name, text, problem):
    (tmp_path / name).write_text(text)
    with pytest.raises(BuildingError, match=problem):
        read_building(tmp_path / name)


def test_the_stored_samples_are_read(data):
    storeys = read_building(data / "graphs" / "indoorgml_pnu_abc.gml", resolution=0.1)
    assert [(s.name, len(s.rooms), len(s.doors)) for s in storeys] == [
        ("F2", 2, 0), ("F3", 7, 7), ("F4", 6, 6),
    ]  # fmt: skip
    assert all(door.rooms for storey in storeys for door in storey.doors)
    assert len(lifts_of(storeys)) == 3
    (storey,) = read_building(data / "graphs" / "osmAG.osm", resolution=1.0)
    assert [len(door.rooms) for door in storey.doors] == [2, 2]
    assert np.ptp(storey.rooms[2].polygons[0], axis=0).max() > 1000.0  # drawn without a scale
