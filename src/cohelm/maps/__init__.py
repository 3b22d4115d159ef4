"""Maps: occupancy grids, their files, distance fields, named places."""

from cohelm.maps.distance import DistanceField, distance_field, signed_distance
from cohelm.maps.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

__all__ = [
    "FREE",
    "OCCUPIED",
    "UNKNOWN",
    "DistanceField",
    "OccupancyGrid",
    "distance_field",
    "signed_distance",
]
