"""GeoJSON files of Nav2's route server: a route graph as one file per storey, and any such file.

A Nav2 graph has one frame and one map, and its nodes are found by x and y alone. So each storey is
a file of its own, beside its map; the ids are unique in the building, and a node in front of a lift
names those on the other storeys.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import value
from cohelm.buildings.route_graph import RouteGraph
from cohelm.errors import MapError

_CRS = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}
"""As in Nav2's own graphs: editors take the coordinates as metres."""


@value
class Nav2Graph:
    """Graph as Nav2's route server loads it, with all that its file holds."""

    content: Mapping[str, Any]
    """The GeoJSON document."""

    @property
    def nodes(self) -> dict[int, Mapping[str, Any]]:
        """Point features by id."""
        return {f["properties"]["id"]: f for f in self.content["features"] if _is_node(f)}

    @property
    def edges(self) -> tuple[Mapping[str, Any], ...]:
        """Line features, each from ``startid`` to ``endid``; several may have one id."""
        return tuple(feature for feature in self.content["features"] if _is_edge(feature))


def read_nav2_graph(file: Path) -> Nav2Graph:
    """Read a graph file of Nav2's route server.

    Raises:
        MapError: if it is missing, no GeoJSON, or Nav2 would refuse it; names the feature.
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as cause:
        raise MapError(f"cannot be read ({cause})", file=file) from None
    features = content.get("features") if isinstance(content, dict) else None
    if not isinstance(features, list):
        raise MapError("no GeoJSON FeatureCollection", file=file)
    nodes: set[int] = set()
    # Nodes first, as Nav2 does: an edge may stand before its nodes.
    for check in (_check_node, _check_edge):
        for k, feature in enumerate(features):
            try:
                check(feature, nodes)
            except (KeyError, TypeError, IndexError, ValueError) as cause:
                raise MapError(f"feature {k}: {cause}", file=file) from None
    if not nodes or not any(map(_is_edge, features)):
        raise MapError("a graph needs nodes (Point) and edges (MultiLineString)", file=file)
    return Nav2Graph(content=content)


def write_nav2_graph(graph: Nav2Graph, file: Path) -> None:
    """Write a graph such that :func:`read_nav2_graph` gives it back.

    Raises:
        MapError: if the file cannot be written.
    """
    features = ",\n".join(json.dumps(f, ensure_ascii=False) for f in graph.content["features"])
    rest = {key: each for key, each in graph.content.items() if key != "features"}
    head = json.dumps(rest, ensure_ascii=False)[1:-1]
    text = "{" + head + (", " if head else "") + '"features": [\n' + features + "\n]}\n"
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as cause:
        raise MapError(f"cannot be written ({cause})", file=file) from cause


def write_route_graph(graph: RouteGraph, folder: Path) -> tuple[Path, ...]:
    """Write ``STEM.route.geojson`` of each storey that has edges; returns the files.

    Raises:
        MapError: if a file cannot be written.
    """
    made = {s.stem: nav2_graph(graph, s.number) for s in graph.storeys}
    files = {folder / f"{stem}.route.geojson": each for stem, each in made.items() if each.edges}
    for file, each in files.items():
        write_nav2_graph(each, file)
    return tuple(files)


def nav2_graph(graph: RouteGraph, storey: int) -> Nav2Graph:
    """One storey of a route graph for Nav2's route server; each way is two edges.

    ``cost`` is the length, m. ``penalty`` is how much longer an edge is than the straight line, so
    that DistanceScorer and PenaltyScorer together count its length.

    Args:
        graph: graph of the building.
        storey: number of the storey.
    """
    here = [i for i, node in enumerate(graph.nodes) if node.storey == storey]
    features = [_node_feature(graph, i) for i in here]
    pairs = sorted(tuple(sorted(pair)) for pair in graph.graph.subgraph(here).edges)
    number = len(graph.nodes) + 2 * sum(
        graph.nodes[min(e)].storey < storey for e in graph.graph.edges
    )
    for one, other in pairs:
        if graph.edge(one, other).kind != "lift":
            for ends in ((one, other), (other, one)):
                features.append(_edge_feature(graph, number, *ends))
                number += 1
    name = graph.storey(storey).stem
    return Nav2Graph(
        content={"type": "FeatureCollection", "name": name, "crs": _CRS, "features": features}
    )


def _node_feature(graph: RouteGraph, i: int) -> dict[str, Any]:
    node, storey = graph.nodes[i], graph.storey(graph.nodes[i].storey)
    about: dict[str, Any] = {
        "class": node.kind, "name": node.name, "room": node.place, "storey": storey.name,
        "map": f"{storey.stem}.yaml",
    }  # fmt: skip
    if node.kind == "lift":
        ends = [j for j in sorted(graph.graph[i]) if graph.edge(i, j).kind == "lift"]
        about["lift_nodes"] = ends
        about["lift_storeys"] = [graph.storey(graph.nodes[j].storey).name for j in ends]
    return {
        "type": "Feature",
        "properties": {"id": i, "frame": "map", "metadata": about},
        "geometry": {"type": "Point", "coordinates": _rounded(node.point)},
    }


def _edge_feature(graph: RouteGraph, number: int, one: int, other: int) -> dict[str, Any]:
    edge = graph.edge(one, other)
    ends = graph.nodes[one], graph.nodes[other]
    straight = float(np.linalg.norm(ends[1].point - ends[0].point))
    about: dict[str, Any] = {
        "class": edge.kind, "room": ends[1].place, "length": round(edge.length, 3),
        "clear_width": round(edge.clear_width, 3), "ramp": edge.ramp,
        "penalty": round(max(edge.length - straight, 0.0), 3),
    }  # fmt: skip
    if (door := edge.door) is not None:
        known = {} if door.threshold is None else {"threshold": door.threshold}
        named = {"id": door.id, "name": door.name, "kind": door.kind, "clear_width": door.width}
        about["door"] = {**named, **known}
    return {
        "type": "Feature",
        "properties": {
            "id": number, "startid": one, "endid": other, "overridable": True, "metadata": about,
            "cost": max(round(edge.length, 3), 0.001),  # Nav2 refuses a cost of 0
        },
        "geometry": {
            "type": "MultiLineString",
            "coordinates": [[_rounded(point) for point in edge.points]],
        },
    }  # fmt: skip


def _rounded(point: Any) -> list[float]:
    return [round(float(each), 4) for each in point]


def _is_node(feature: Any) -> bool:
    return bool(feature["geometry"]["type"] == "Point")


def _is_edge(feature: Any) -> bool:
    return feature["geometry"]["type"] in {"LineString", "MultiLineString"}


def _check_node(feature: Mapping[str, Any], nodes: set[int]) -> None:
    """Check what Nav2 needs of a node, and note its id; raises ValueError and the like."""
    if _is_node(feature):
        number = feature["properties"]["id"]
        if not isinstance(number, int) or number < 0 or number in nodes:
            raise ValueError(f"id {number!r} is no whole number of its own")
        nodes.add(number)
        at = [float(each) for each in feature["geometry"]["coordinates"][:2]]
        if len(at) < 2 or not all(map(math.isfinite, at)):
            raise ValueError("coordinates are no x, y")


def _check_edge(feature: Mapping[str, Any], nodes: set[int]) -> None:
    """Check that an edge joins nodes; raises ValueError and the like."""
    if _is_edge(feature):
        about = feature["properties"]
        if not {about["startid"], about["endid"]} <= nodes:
            raise ValueError(f"edge {about['id']} joins nodes that are not there")
