"""All measures of one ride by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cohelm.evaluation.metrics import groups, motion, people, rider, route
from cohelm.evaluation.ride import Outcome, Ride
from cohelm.evaluation.unmet import unmet

MEASURES: dict[str, Callable[[Ride], float]] = {
    "success": lambda ride: ride.outcome is Outcome.REACHED,
    "time": motion.time,
    "path_length": motion.path_length,
    "path_length_short": motion.path_length_short,
    "encounters": people.encounters,
    "min_distance": people.min_distance,
    "mean_distance": people.mean_distance,
    "collisions_person": people.collisions_person,
    "collisions_wall": people.collisions_wall,
    "standing_contacts": people.standing_contacts,
    "wall_distance": lambda ride: float(ride.gap_wall.min().clip(min=0.0)),
    "time_to_collision": people.time_to_collision,
    "proxemics_intimate": lambda ride: people.proxemics(ride, 0.0, 0.45),
    "proxemics_personal": lambda ride: people.proxemics(ride, 0.45, 1.2),
    "proxemics_social": lambda ride: people.proxemics(ride, 1.2, 3.6),
    "social_space_intrusion": people.social_space_intrusion,
    "social_space_intrusion_share": people.social_space_intrusion_share,
    "group_space_intrusion": groups.group_space_intrusion,
    "group_space_intrusion_share": groups.group_space_intrusion_share,
    "pedestrian_delay": lambda ride: people.pedestrian_delay(ride, unmet(ride)),
    "pedestrian_deviation": lambda ride: people.pedestrian_deviation(ride, unmet(ride)),
    "beside_share": people.beside_share,
    "linear_velocity_variance": lambda ride: float(np.var(ride.twist[:, 0])),
    "angular_velocity_variance": lambda ride: float(np.var(ride.twist[:, 2])),
    "linear_velocity_variance_underway": lambda ride: float(np.var(motion.underway(ride)[:, 0])),
    "angular_velocity_variance_underway": lambda ride: float(np.var(motion.underway(ride)[:, 2])),
    "heading_change": motion.heading_change,
    "acceleration_max": lambda ride: float(np.abs(motion.acceleration(ride)).max(initial=0.0)),
    "acceleration_rms": lambda ride: motion.rms(motion.acceleration(ride)),
    "jerk_max": lambda ride: float(np.abs(motion.jerk(ride)).max(initial=0.0)),
    "jerk_rms": lambda ride: motion.rms(motion.jerk(ride)),
    "stalled_time": motion.stalled_time,
    "path_error": route.ride_error,
    "path_hausdorff": route.ride_hausdorff,
    "preference_distance": route.preference_distance,
    "spl": route.spl,
    "authority": lambda ride: float(ride.eta.mean()),
    "agreement": rider.agreement,
    "disagreement": rider.disagreement,
    "intervention_share": rider.intervention_share,
    "fight_rate": rider.fight_rate,
    "rider_effort": rider.effort,
    "rider_reversals": rider.reversals,
}
"""Name → measure, in the order of a table."""


def measure(ride: Ride) -> dict[str, float]:
    """Every measure by its name; NaN where it has no meaning in this ride."""
    return {name: each(ride) for name, each in MEASURES.items()}


def timing(ride: Ride) -> dict[str, dict[str, float]]:
    """Thread CPU time a tick by stage, s: median, 99th percentile and worst but for the first.

    The first tick, which compiles what is not compiled yet, stands apart.
    """
    out = {}
    for stage, each in sorted(ride.durations.items()):
        later = each[1:] if len(each) > 1 else each
        out[stage] = {
            "median": float(np.median(later)),
            "p99": float(np.percentile(later, 99)),
            "max": float(later.max()),
            "first": float(each[0]),
        }
    return out
