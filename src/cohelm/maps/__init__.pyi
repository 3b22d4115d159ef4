from .distance import DistanceField, distance_field, signed_distance
from .floorplan import DoorOpening, FloorPlan, Furniture, Space, read_floor_plan
from .grid import FREE, MAX_COORDINATE, OCCUPIED, UNKNOWN, OccupancyGrid
from .masks import (
    FILTER_TYPES,
    CostmapFilter,
    FilterInfo,
    FilterType,
    closed_cells,
    read_crowding,
    read_filter_info,
    read_mask,
    speed_limit_at,
)
from .nav2 import MapFile, read_map, write_map
from .nav2_yaml import MapWarning
from .places import (
    NamedPlace,
    Places,
    innermost_point,
    places_beside,
    read_places,
    write_places,
)

__all__ = [
    "FILTER_TYPES",
    "FREE",
    "MAX_COORDINATE",
    "OCCUPIED",
    "UNKNOWN",
    "CostmapFilter",
    "DistanceField",
    "DoorOpening",
    "FilterInfo",
    "FilterType",
    "FloorPlan",
    "Furniture",
    "MapFile",
    "MapWarning",
    "NamedPlace",
    "OccupancyGrid",
    "Places",
    "Space",
    "closed_cells",
    "distance_field",
    "innermost_point",
    "places_beside",
    "read_crowding",
    "read_filter_info",
    "read_floor_plan",
    "read_map",
    "read_mask",
    "read_places",
    "signed_distance",
    "speed_limit_at",
    "write_map",
    "write_places",
]
