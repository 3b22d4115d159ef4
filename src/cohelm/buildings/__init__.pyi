from .accessibility import AccessBarrier, AccessReport, RoomAccess, accessibility
from .directions import Direction, directions
from .free_space import Partition, partition
from .graph_files import Nav2Graph, read_nav2_graph, write_nav2_graph, write_route_graph
from .lifts import Lift, LiftLanding, lifts_of
from .route_graph import BuildingRoute, RouteEdge, RouteGraph, RouteNode, RouteWishes, route_graph
from .storey import BuildingStorey, Door, Room, StoreyLink, polygon_cells
from .storey_files import (
    door_sides,
    read_building,
    read_storeys,
    room_names,
    room_places,
    storey_record,
    write_storey,
)

__all__ = [
    "AccessBarrier",
    "AccessReport",
    "BuildingRoute",
    "BuildingStorey",
    "Direction",
    "Door",
    "Lift",
    "LiftLanding",
    "Nav2Graph",
    "Partition",
    "Room",
    "RoomAccess",
    "RouteEdge",
    "RouteGraph",
    "RouteNode",
    "RouteWishes",
    "StoreyLink",
    "accessibility",
    "directions",
    "door_sides",
    "lifts_of",
    "partition",
    "polygon_cells",
    "read_building",
    "read_nav2_graph",
    "read_storeys",
    "room_names",
    "room_places",
    "route_graph",
    "storey_record",
    "write_nav2_graph",
    "write_route_graph",
    "write_storey",
]
