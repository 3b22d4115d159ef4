"""Maps: occupancy grids, their files, distance fields, named places, floor plans."""

from cohelm.maps.distance import DistanceField, distance_field, signed_distance
from cohelm.maps.floorplan import Door, FloorPlan, Furniture, Space, read_floor_plan
from cohelm.maps.grid import FARTHEST, FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from cohelm.maps.masks import (
    CostmapFilter,
    FilterType,
    closed_cells,
    read_crowding,
    read_mask,
    speed_limit_at,
)
from cohelm.maps.nav2 import MapFile, MapWarning, read_map, write_map
from cohelm.maps.places import (
    Place,
    Places,
    innermost_point,
    places_beside,
    read_places,
    write_places,
)

__all__ = [
    "FARTHEST",
    "FREE",
    "OCCUPIED",
    "UNKNOWN",
    "CostmapFilter",
    "DistanceField",
    "Door",
    "FilterType",
    "FloorPlan",
    "Furniture",
    "MapFile",
    "MapWarning",
    "OccupancyGrid",
    "Place",
    "Places",
    "Space",
    "closed_cells",
    "distance_field",
    "innermost_point",
    "places_beside",
    "read_crowding",
    "read_floor_plan",
    "read_map",
    "read_mask",
    "read_places",
    "signed_distance",
    "speed_limit_at",
    "write_map",
    "write_places",
]
