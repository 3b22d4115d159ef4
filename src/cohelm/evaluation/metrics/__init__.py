"""Measures of a ride, one definition each: SI units, distances from surface to surface."""

from cohelm.evaluation.metrics.measures import (
    MEASURES,
    RIDE_MEASURES,
    Family,
    RideMeasure,
    measure,
    measure_info,
    measure_table,
    timing,
)
from cohelm.evaluation.metrics.motion import path_error
from cohelm.evaluation.metrics.people import pedestrian_delay, pedestrian_deviation

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
