"""Route graphs: authored buildings with known routes, and the planner's reachability on models."""

import dataclasses
import itertools
import math

import networkx as nx
import numpy as np
import pytest
from scipy import ndimage
from tests.buildings.authored import lift_tower, two_rooms, ward_block

from cohelm import plugins
from cohelm.buildings import (
    RouteWishes,
    StoreyLink,
    directions,
    read_building,
    route_graph,
)
from cohelm.errors import ConfigError, NoRoute, PlanningError
from cohelm.geometry import resample
from cohelm.maps import signed_distance
from cohelm.planning import RouteProblem
from cohelm.robots import load_robot


def graph_of(author, folder):
    return route_graph(read_building(author.write(folder / "model.ifc")))


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    return graph_of(ward_block(narrow=0.65), tmp_path_factory.mktemp("block"))


def between(graph, start, goal, **options):
    return graph.route(graph.find(start), graph.find(goal), **options)


def doors(route):
    return [edge.door.name for edge in route.edges if edge.kind == "door"]


def test_a_route_to_another_storey_takes_the_lift(block):
    route = between(block, "Foyer", "Ward 3", width=0.7)
    assert doors(route) == ["A0", "A1"]
    assert [edge.kind for edge in route.edges].count("lift") == 1
    assert [step.text for step in directions(block, route)] == [
        "Start in Foyer.",
        "Go through the door to South Corridor.",
        "Turn right and go along South Corridor for 11 m.",
        "Take the lift to Level 2.",
        "Turn right and go along North Corridor for 11 m.",
        "Go through the door on your left.",
        "You are at Ward 3.",
    ]


def test_the_way_back_turns_the_other_way(block):
    steps = directions(block, between(block, "Ward 3", "Foyer", width=0.7))
    assert [step.side for step in steps if step.kind == "along"] == ["right", "right"]
    assert [step.storey for step in steps if step.kind == "lift"] == ["Level 1"]
    assert steps[-2].side == "left"


def test_a_door_that_is_narrower_than_the_chair_is_avoided(block):
    assert doors(between(block, "Store", "Lift A @ 1", width=0.5)) == ["B0"]
    assert doors(between(block, "Store", "Lift A @ 1", width=0.7)) == ["C0", "A0"]


def test_the_door_that_is_too_narrow_is_named(block):
    with pytest.raises(NoRoute, match=r"too narrow is the door 'L0'|the door 'A0' .*1\.00 m wide"):
        between(block, "Foyer", "Ward 3", width=1.2)
    with pytest.raises(NoRoute, match=r"needs 0\.99 m, too narrow is the door 'B1' \(North") as one:
        between(block, "North Corridor", "Radiology", width=0.99)
    assert "1.00 m wide, 0.9" in str(one.value)


def test_places_that_nothing_joins_are_said_so(tmp_path):
    author, _ = two_rooms()
    author.storey("First Floor", 3.0)
    author.box("IfcSpace", (0.2, 0.2, 0), (4.2, 3.2, 2.5), Name="201", LongName="Attic")
    graph = graph_of(author, tmp_path)
    with pytest.raises(NoRoute, match="no route from Office @ Ground Floor to Attic @ First Floor"):
        between(graph, "Office", "Attic")


def test_wishes_change_the_route(block):
    (foyer,) = block.rooms("Foyer")
    (corridor,) = block.rooms("South Corridor")
    wishes = RouteWishes(avoid={foyer}, ramp_price=30.0).each_without()
    assert wishes.keys() == {"avoid", "level"}
    assert (wishes["avoid"].avoid, wishes["avoid"].ramp_price) == (frozenset(), 30.0)
    assert doors(between(block, "Store", "Lift A @ 1")) == ["B0"]
    wide = between(block, "Store", "Lift A @ 1", wishes=RouteWishes(narrow_price=20.0))
    assert doors(wide) == ["C0", "A0"]
    around = between(block, "Store", "Lift A @ 1", wishes=RouteWishes(avoid={foyer}), width=0.5)
    assert doors(around) == ["B0"]
    passed = between(block, "Store", "Lift A @ 1", wishes=RouteWishes(avoid={foyer}), width=0.7)
    assert doors(passed) == ["C0", "A0"]
    with pytest.raises(NoRoute, match="rooms never to enter close every way"):
        between(block, "Foyer", "Ward 3", wishes=RouteWishes(closed={corridor}))


def test_a_ramp_is_avoided_on_wish(tmp_path):
    first, second = read_building(ward_block(narrow=1.0).write(tmp_path / "model.ifc"))
    outline = np.array([[5.0, 1.0], [6.0, 1.0], [6.0, 3.8], [5.0, 3.8]])  # before the door C0
    ramp = StoreyLink(id="r", kind="ramp", name="", polygon=outline)
    graph = route_graph([dataclasses.replace(first, links=(*first.links, ramp)), second])
    assert doors(between(graph, "Foyer", "Store")) == ["C0"]
    level = between(graph, "Foyer", "Store", wishes=RouteWishes(ramp_price=30.0))
    assert doors(level) == ["A0", "B0"]


def test_places_have_names_and_numbers(block):
    assert block.find("a1") == block.find("FOYER") == block.find("A1 Foyer @ level 1")
    with pytest.raises(ConfigError, match="'Lift A' may be 'Lift A @ Level 1' or 'Lift A @ Lev"):
        block.find("Lift A")
    with pytest.raises(ConfigError, match="no place 'Wardd'; did you mean 'Ward 3'"):
        block.find("Wardd")


def test_lengths_obey_the_triangle_law_and_are_symmetric(block):
    ends = [i for i, node in enumerate(block.nodes) if node.storey == 1]
    length = {(a, b): block.route(a, b).length for a in ends for b in ends}
    for a, b, c in itertools.product(ends, repeat=3):
        assert length[a, b] == pytest.approx(length[b, a])
        assert length[a, b] <= length[a, c] + length[c, b] + 1e-9
        assert length[a, b] >= np.hypot(*(block.nodes[a].point - block.nodes[b].point)) - 1e-9


def test_edges_end_at_their_nodes_and_are_as_long_as_their_points(block):
    for one, other in block.graph.edges:
        edge = block.edge(one, other)
        if edge.kind != "lift":
            assert edge.points[0] == pytest.approx(block.nodes[one].point)
            assert edge.points[-1] == pytest.approx(block.nodes[other].point)
            corners = np.linalg.norm(np.diff(edge.points, axis=0), axis=1).sum()
            assert corners <= edge.length + 1e-9
            assert corners >= 0.9 * edge.length - 0.1


def test_ways_within_rooms_keep_away_from_walls(block):
    for one, other in block.graph.edges:
        edge = block.edge(one, other)
        if edge.kind == "walk" and edge.clear_width > 0.9:
            grid = block.storey(block.nodes[one].storey).grid
            cells = grid.cells(resample(edge.points, 0.05))
            assert signed_distance(grid.blocked(), grid.resolution)[tuple(cells.T)].min() > 0.3


def test_a_door_is_as_wide_as_on_the_map(tmp_path):
    graph = graph_of(two_rooms(door=0.9)[0], tmp_path)
    (edge,) = (graph.edge(*pair) for pair in graph.graph.edges if graph.edge(*pair).kind == "door")
    assert 0.9 - 2 * 0.05 - 0.01 <= edge.clear_width <= 0.9 + 0.01


def round_robot(radius):
    """A robot that may turn wherever it may be."""
    robot = load_robot("quantum_q6_edge")
    angle = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    corners = radius / math.cos(np.pi / 64.0) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return robot.model_copy(update={"footprint": tuple(map(tuple, corners.tolist()))})


def parts_of(graph, width):
    """Nodes that edges of at least that width join, by node."""
    fits = nx.Graph([e for e in graph.graph.edges if graph.edge(*e).clear_width >= width])
    return {i: part for part in nx.connected_components(fits) for i in part}


def planned(planner, grid, robot, start, goal):
    try:
        planner.plan(RouteProblem(grid=grid, robot=robot, start=start, goal=goal))
    except PlanningError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("AC11-FZK-Haus", 1), ("Duplex_Architecture_2x3", 2), ("Duplex_Architecture_2x3", 3),
        ("SampleHouse_IFC4", 1), ("bimwhale_LargeBuilding", 1),
    ],
)  # fmt: skip
@pytest.mark.parametrize("radius", [0.3, 0.38])
def test_rooms_are_joined_where_the_planner_finds_a_path(data, name, number, radius):
    (storey,) = read_building(data / "ifc" / f"{name}.ifc", storey=str(number))
    graph, robot = route_graph([storey]), round_robot(radius)
    planner = plugins.build("global_planners", {"use": "astar"}, key="")
    part = parts_of(graph, 2.0 * robot.inscribed_radius)
    rooms = [i for i, node in enumerate(graph.nodes) if node.kind == "room" and node.name]
    assert len(rooms) == len(storey.rooms)
    for one, other in itertools.combinations(rooms, 2):
        ends = graph.nodes[one].point, graph.nodes[other].point
        joined = other in part.get(one, {one})
        assert planned(planner, storey.grid, robot, *ends) == joined


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::cohelm.maps.MapWarning")
@pytest.mark.parametrize("name", ["aws_hospital_sim", "intel_lab", "utexas_gdc_1n"])
def test_rooms_of_a_plain_map_are_joined_where_a_disc_gets_through(data, name):
    (storey,) = read_building(data / "ros_maps" / f"{name}.yaml")
    graph, grid = route_graph([storey]), storey.grid
    clearance = signed_distance(grid.blocked(), grid.resolution)
    rooms = [i for i, node in enumerate(graph.nodes) if node.kind == "room" and node.name]
    for radius in (0.3, 0.38):
        floor = ndimage.label(clearance >= radius)[0]
        at = {i: floor[tuple(grid.cells(graph.nodes[i].point))] for i in rooms}
        part = parts_of(graph, 2.0 * radius)
        for one, other in itertools.combinations([i for i in rooms if at[i]], 2):
            assert (at[one] == at[other]) == (other in part.get(one, {one}))


def test_a_lift_that_is_a_room_is_not_driven_through(tmp_path):
    author = ward_block()
    author.box(
        "IfcSpace", (12.2, 6.2, 0), (13.8, 8, 2.5), storey=author.storeys[0], Name="A9",
        LongName="Lift",
    )  # fmt: skip
    graph = graph_of(author, tmp_path)
    assert {node.kind for node in graph.nodes if node.name == "Lift"} == {"lift"}
    assert doors(between(graph, "Foyer", "Ward 3", width=0.7)) == ["A0", "A1"]


def test_the_waiting_place_is_in_front_of_the_door_of_the_lift(block):
    for number in (1, 2):
        (node,) = (n for n in block.nodes if n.kind == "lift" and n.storey == number)
        assert 12.5 < node.point[0] < 13.5  # the door L0 or L1, at y = 6
        assert 4.8 < node.point[1] < 5.6


@pytest.mark.parametrize(("depth", "waits"), [(0.3, False), (1.0, True)])
def test_a_lift_with_no_room_in_front_of_its_door_has_no_waiting_place(tmp_path, depth, waits):
    author = ward_block()
    author.box(
        "IfcWall", (11.5, 6 - depth - 0.1, 0), (15.8, 6 - depth, 2.5), storey=author.storeys[0]
    )
    graph = graph_of(author, tmp_path)
    points = [node.point for node in graph.nodes if node.kind == "lift" and node.storey == 1]
    assert [bool(12.5 < x < 13.5 and y > 6 - depth) for x, y in points] == [True] * waits
    said = [n for n in graph.notes if "no waiting place in front of 'Lift A' on Level 1" in n]
    assert bool(said) != waits
    if not waits:
        with pytest.raises(NoRoute, match="to Ward 3 @ Level 2: no waiting place in front of 'Li"):
            between(graph, "Foyer", "Ward 3")


def test_the_waiting_place_lies_beyond_a_strip_of_floor_without_a_room(tmp_path):
    graph = graph_of(lift_tower(rooms=(("1", "Hall"), ("2", "Office"), ("3", "Ward"))), tmp_path)
    points = [node.point for node in graph.nodes if node.kind == "lift"]
    assert len(points) == 3
    for x, y in points:  # the door is from x = 4.5 to 5.5, at y = 2; the room begins at y = 2.2
        assert 4.5 < x < 5.5
        assert 2.6 < y < 3.5


def test_floor_in_no_room_is_a_part_of_the_way(tmp_path):
    author = ward_block()
    for space in author.model.by_type("IfcSpace"):
        if "Corridor" in space.LongName:
            author.model.remove(space)
    graph = graph_of(author, tmp_path)
    route = between(graph, "Foyer", "Ward 3", width=0.7)
    assert doors(route) == ["A0", "A1"]
    texts = [step.text for step in directions(graph, route)]
    assert texts[1:3] == ["Go through the door.", "Turn right and go straight on for 11 m."]


def test_a_graph_is_a_value(block):
    assert dataclasses.is_dataclass(block)
    assert block.graph.number_of_nodes() == len(block.nodes)
