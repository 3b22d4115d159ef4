"""Graph files of Nav2's route server, and storeys read back from their files."""

import dataclasses
import json

import networkx as nx
import numpy as np
import pytest
from tests.buildings.authored import two_rooms, ward_block

from cohelm.arrays import identical
from cohelm.buildings import (
    read_building,
    read_nav2_graph,
    read_storeys,
    route_graph,
    write_nav2_graph,
    write_route_graph,
    write_storey,
)
from cohelm.errors import BuildingError, MapError


@pytest.fixture(scope="module")
def storeys(tmp_path_factory):
    return read_building(ward_block().write(tmp_path_factory.mktemp("block") / "model.ifc"))


def test_nav2_s_own_graph_is_kept_as_it_is(data, tmp_path):
    file = data / "graphs" / "nav2_depot_graph.geojson"
    graph = read_nav2_graph(file)
    write_nav2_graph(graph, tmp_path / "copy.geojson")
    assert json.loads((tmp_path / "copy.geojson").read_text()) == json.loads(file.read_text())
    ends = {edge["properties"][key] for edge in graph.edges for key in ("startid", "endid")}
    assert ends <= set(graph.nodes)


def test_unknown_fields_and_operations_are_kept(tmp_path):
    def feature(about, kind, at, **more):
        return {
            "type": "Feature",
            "properties": about,
            "geometry": {"type": kind, "coordinates": at},
        } | more

    stop = {"type": "stop", "trigger": "ON_ENTER", "metadata": {"a": {"b": [1, 2.5]}}}
    edge = {"id": 8, "startid": 0, "endid": 7, "cost": 3, "overridable": False}
    features = [
        feature({"id": 0, "frame": "map", "metadata": {"c": "d"}}, "Point", [0, 1], bbox=[0]),
        feature({"id": 7, "operations": [stop]}, "Point", [2, 1]),
        feature(edge, "LineString", []),
        feature({"of": "somebody"}, "Polygon", []),
    ]
    content = {"type": "FeatureCollection", "vendor": {"x": None}, "features": features}
    (tmp_path / "a.geojson").write_text(json.dumps(content))
    write_nav2_graph(read_nav2_graph(tmp_path / "a.geojson"), tmp_path / "b.geojson")
    assert json.loads((tmp_path / "b.geojson").read_text()) == content


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda f: f.pop(0), "edge .* joins nodes that are not there"),
        (lambda f: f[1]["properties"].update(id=f[0]["properties"]["id"]), "feature 1: id .* own"),
        (lambda f: f[0]["geometry"].update(coordinates=[1.0]), "feature 0"),
        (lambda f: f[0].pop("geometry"), "feature 0"),
        (lambda f: f.clear(), "needs nodes"),
    ],
)
def test_a_graph_that_nav2_refuses_is_refused(data, tmp_path, change, problem):
    content = json.loads((data / "graphs" / "nav2_depot_graph.geojson").read_text())
    change(content["features"])
    (tmp_path / "bad.geojson").write_text(json.dumps(content))
    with pytest.raises(MapError, match=problem):
        read_nav2_graph(tmp_path / "bad.geojson")


def leaves(part):
    """All values in the metadata that Nav2 converts, of lists and mappings too."""
    if isinstance(part, dict | list):
        for each in part.values() if isinstance(part, dict) else part:
            yield from leaves(each)
    else:
        yield part


def test_a_route_graph_is_written_as_nav2_loads_it(storeys, tmp_path):
    graph = route_graph(storeys)
    files = write_route_graph(graph, tmp_path)
    assert [file.name for file in files] == ["level-1.route.geojson", "level-2.route.geojson"]
    graphs = [read_nav2_graph(file) for file in files]
    ids = [f["properties"]["id"] for each in graphs for f in each.content["features"]]
    assert len(ids) == len(set(ids))
    for each in graphs:
        for feature in each.content["features"]:
            values = list(leaves(feature["properties"].get("metadata", {})))
            assert all(isinstance(value, str | int | float) for value in values)
        assert all(edge["properties"]["cost"] > 0.0 for edge in each.edges)
    first = graphs[0]
    (lift,) = (n for n in first.nodes.values() if n["properties"]["metadata"]["class"] == "lift")
    assert lift["properties"]["metadata"]["lift_storeys"] == ["Level 2"]
    assert set(lift["properties"]["metadata"]["lift_nodes"]) <= set(graphs[1].nodes)


def test_the_costs_of_the_file_are_the_lengths_of_the_graph(storeys, tmp_path):
    graph = route_graph(storeys)
    read = read_nav2_graph(write_route_graph(graph, tmp_path)[0])
    nav2 = nx.DiGraph()
    for edge in read.edges:
        about = edge["properties"]
        ends = (
            np.array(read.nodes[about[k]]["geometry"]["coordinates"]) for k in ("startid", "endid")
        )
        straight = np.linalg.norm(np.subtract(*ends))
        assert about["cost"] == pytest.approx(straight + about["metadata"]["penalty"], abs=2e-3)
        nav2.add_edge(about["startid"], about["endid"], cost=about["cost"])
    start, goal = graph.find("Foyer"), graph.find("Store")
    length = nx.dijkstra_path_length(nav2, start, goal, weight="cost")
    assert length == pytest.approx(graph.route(start, goal).length, abs=0.01)


def test_storeys_are_read_back_as_they_were_written(storeys, tmp_path):
    for storey in storeys:
        write_storey(storey, tmp_path)
    for storey, read in zip(storeys, read_storeys(tmp_path), strict=True):
        same_storey(storey, read)


@pytest.mark.parametrize("name", ["AC11-FZK-Haus", "Duplex_Architecture_2x3"])
def test_storeys_of_models_are_read_back(data, tmp_path, name):
    storeys = read_building(data / "ifc" / f"{name}.ifc")
    for storey in storeys:
        write_storey(storey, tmp_path)
    for storey, read in zip(storeys, read_storeys(tmp_path), strict=True):
        same_storey(storey, read)


def same_storey(one, other):
    names = ("name", "stem", "number", "notes")
    assert [getattr(one, key) for key in names] == [getattr(other, key) for key in names]
    assert one.elevation == pytest.approx(other.elevation, abs=1e-4)
    if not one.grid.blocked().all():
        assert identical(one.grid, other.grid)
    for parts, others in (
        (one.rooms, other.rooms),
        (one.doors, other.doors),
        (one.links, other.links),
    ):
        assert len(parts) == len(others)
        for part, its in zip(parts, others, strict=True):
            for field in dataclasses.fields(part):
                same(getattr(part, field.name), getattr(its, field.name))


def same(value, other):
    if isinstance(value, tuple) and value and isinstance(value[0], np.ndarray):
        for one, its in zip(value, other, strict=True):
            same(one, its)
    elif isinstance(value, float | np.ndarray):
        assert other == pytest.approx(value, abs=1e-4)
    else:
        assert value == other


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"rooms": 3}', '{"map": 1, "notes": []}'])
def test_a_record_that_is_none_is_refused(tmp_path, text):
    (tmp_path / "a.storey.json").write_text(text)
    with pytest.raises(BuildingError, match="no record of a storey"):
        read_storeys(tmp_path)


def test_two_buildings_in_one_folder_are_refused(storeys, tmp_path):
    write_storey(storeys[0], tmp_path)
    write_storey(dataclasses.replace(storeys[0], stem="other"), tmp_path)
    with pytest.raises(BuildingError, match="level-1 and other are both storey 1"):
        read_storeys(tmp_path)


def test_a_folder_without_a_building_is_refused(tmp_path):
    with pytest.raises(BuildingError, match="no storey"):
        read_storeys(tmp_path)


def test_a_storey_of_one_room_has_no_graph_file(tmp_path):
    author, _ = two_rooms(spaces=False)
    author.storey("First Floor", 3.0)
    author.box("IfcSlab", (0, 0, -0.2), (3, 3, 0.0))
    author.box("IfcSpace", (0, 0, 0), (3, 3, 2.5), Name="201")
    graph = route_graph(read_building(author.write(tmp_path / "model.ifc")))
    assert [file.name for file in write_route_graph(graph, tmp_path)] == [
        "ground-floor.route.geojson"
    ]
