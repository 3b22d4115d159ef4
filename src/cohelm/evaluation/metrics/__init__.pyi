from .measures import (
    MEASURES,
    RIDE_MEASURES,
    Family,
    RideMeasure,
    measure,
    measure_info,
    measure_table,
    timing,
)
from .motion import path_error
from .people import pedestrian_delay, pedestrian_deviation

__all__ = [
    "MEASURES",
    "RIDE_MEASURES",
    "Family",
    "RideMeasure",
    "measure",
    "measure_info",
    "measure_table",
    "path_error",
    "pedestrian_delay",
    "pedestrian_deviation",
    "timing",
]
