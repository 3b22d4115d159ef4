from .building import read_building
from .free_space import Partition, partition
from .storey import BuildingStorey, Door, Room, StoreyLink
from .storey_files import room_names, room_places, storey_record, write_storey

__all__ = [
    "BuildingStorey",
    "Door",
    "Partition",
    "Room",
    "StoreyLink",
    "partition",
    "read_building",
    "room_names",
    "room_places",
    "storey_record",
    "write_storey",
]
