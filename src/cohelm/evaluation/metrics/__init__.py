"""Every measure of a ride, one definition each: SI, distances from surface to surface."""

from cohelm.evaluation.metrics.people import pedestrian_delay, pedestrian_deviation
from cohelm.evaluation.metrics.route import path_error
from cohelm.evaluation.metrics.table import measure, timing

__all__ = ["measure", "path_error", "pedestrian_delay", "pedestrian_deviation", "timing"]
