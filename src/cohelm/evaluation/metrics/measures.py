"""Table of all measures: label, unit, direction and definition, for every report and the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np

from cohelm.evaluation.episode.counterfactual import counterfactual
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.metrics import comfort, motion, people, rider


class Family(StrEnum):
    """Subject of a measure."""

    OUTCOME = "outcome"
    SAFETY = "people and walls"
    EFFICIENCY = "time and path"
    COMFORT = "comfort"
    RIDER = "rider proxies"
    """Computed from stick and wheels, not from the opinion of a person."""
    OPINION = "ratings"
    PROGRAM = "computing time"


@dataclass(frozen=True)
class RideMeasure:
    """Measure of a ride, or a column that is derived from rides."""

    label: str
    unit: str = ""
    better: int = 0
    """1: larger is better, −1: smaller is better, 0: neither."""
    family: Family = Family.EFFICIENCY
    digits: int = 2
    """Decimals in a table."""
    compute: Callable[[Ride], float] | None = None
    """Definition; None for a column that is derived from rows."""

    @property
    def of_rides(self) -> bool:
        """Yes or no for each ride: reports show the share of rides."""
        return self.unit == OF_RIDES

    @property
    def heading(self) -> str:
        """Label with its unit: ``time to goal, s``."""
        return f"{self.label}, {self.unit}" if self.unit else self.label

    def of(self, ride: Ride) -> float:
        """Value for a ride; NaN where the measure does not apply, or is not one of a ride."""
        return math.nan if self.compute is None else self.compute(ride)

    def text(self, x: float) -> str:
        """Value with the table's decimals, a share in percent; ``–`` where there is none."""
        if not math.isfinite(x):
            return "–"
        text = f"{100.0 * x if self.unit in {PERCENT, OF_RIDES} else x:.{self.digits}f}"
        return text if float(text) else text.removeprefix("-")


PERCENT = "%"
"""Unit of a share of time, whose value is 0…1."""
OF_RIDES = "% of rides"


def _rides(label: str, better: int, family: Family = Family.OUTCOME) -> RideMeasure:
    return RideMeasure(label, OF_RIDES, better, family, 0)


_safety = partial(RideMeasure, family=Family.SAFETY)
_comfort = partial(RideMeasure, better=-1, family=Family.COMFORT, digits=3)
_rider = partial(RideMeasure, family=Family.RIDER)
_milliseconds = partial(RideMeasure, unit="ms", better=-1, family=Family.PROGRAM)

MEASURES: Mapping[str, RideMeasure] = {
    "success": RideMeasure(
        "success", "", 1, Family.OUTCOME, 0, lambda ride: ride.outcome is Outcome.REACHED
    ),
    "reached": _rides("goal reached", 1),
    "as_wanted": _rides("arrived as the rider wanted", 1),
    "person_collision": _rides("collision with a person", -1),
    "standing_contact": _rides("contact while standing", -1),
    "wall_collision": _rides("collision with a wall", -1),
    "program_error": _rides("program error", -1, Family.PROGRAM),
    "time": RideMeasure("time to goal", "s", -1, compute=motion.time),
    "time_ratio": RideMeasure("time ratio to empty floor", "", -1),
    "path_length": RideMeasure("path length", "m", -1, compute=motion.path_length),
    "path_length_short": RideMeasure(
        "path length to 0.3 m before the goal", "m", -1, compute=motion.path_length_short
    ),
    "spl": RideMeasure("success weighted by path length", "", 1, compute=motion.spl),
    "stalled_time": RideMeasure("time standing", "s", -1, compute=motion.stalled_time),
    "replan_count": RideMeasure("new paths", "", 0, digits=1),
    "path_error": RideMeasure("mean distance from the first route", "m", compute=motion.ride_error),
    "path_hausdorff": RideMeasure(
        "largest distance from the first route", "m", compute=motion.ride_hausdorff
    ),
    "preference_distance": RideMeasure(
        "distance from the via point", "m", -1, compute=motion.preference_distance
    ),
    "time_empty_floor": RideMeasure("time to goal on the empty floor", "s"),
    "encounters": _safety("people within 2 m", digits=1, compute=people.encounters),
    "min_distance": _safety("nearest person", "m", 1, compute=people.min_distance),
    "mean_distance": _safety("mean distance of the nearest person", "m", 1,
                             compute=people.mean_distance),
    "collision_speed": _safety("speed at a collision", "m/s", -1),
    "collisions_person": _safety("collisions with people", "", -1,
                                 compute=people.collisions_person),
    "collisions_wall": _safety("collisions with walls", "", -1, compute=people.collisions_wall),
    "standing_contacts": _safety("contacts while standing", "", -1,
                                 compute=people.standing_contacts),
    "wall_distance": _safety("nearest wall", "m", 1,
                             compute=lambda ride: float(ride.gap_wall.min().clip(min=0.0))),
    "time_to_collision": _safety("shortest time to collision", "s", 1,
                                 compute=people.time_to_collision),
    "proxemics_intimate": _safety("time with a person within 0.45 m", PERCENT, -1, digits=1,
                                  compute=lambda ride: people.proxemics(ride, 0.0, 0.45)),
    "proxemics_personal": _safety("time with the nearest person at 0.45 to 1.2 m", PERCENT,
                                  digits=1,
                                  compute=lambda ride: people.proxemics(ride, 0.45, 1.2)),
    "proxemics_social": _safety("time with the nearest person at 1.2 to 3.6 m", PERCENT, digits=1,
                                compute=lambda ride: people.proxemics(ride, 1.2, 3.6)),
    "social_space_intrusion": _safety("intrusion into personal space, depth × time", "s", -1,
                                      compute=people.social_space_intrusion),
    "social_space_intrusion_share": _safety("time in personal space", PERCENT, -1, digits=1,
                                            compute=people.social_space_intrusion_share),
    "group_space_intrusion": _safety("intrusion into group space, depth × time", "s", -1,
                                     compute=people.group_space_intrusion),
    "group_space_intrusion_share": _safety("time in group space", PERCENT, -1, digits=1,
                                           compute=people.group_space_intrusion_share),
    "pedestrian_delay": _safety(
        "delay of pedestrians", "s", -1,
        compute=lambda ride: people.pedestrian_delay(ride, counterfactual(ride)),
    ),
    "pedestrian_deviation": _safety(
        "deviation of pedestrians", "m", -1,
        compute=lambda ride: people.pedestrian_deviation(ride, counterfactual(ride)),
    ),
    "side_by_side_share": _safety("time side by side with the companion", PERCENT, 1, digits=1,
                                  compute=people.side_by_side_share),
    "linear_velocity_variance": _comfort("variance of speed", "m²/s²", digits=4,
                                         compute=lambda ride: float(np.var(ride.twist[:, 0]))),
    "angular_velocity_variance": _comfort("variance of turn rate", "rad²/s²", digits=4,
                                          compute=lambda ride: float(np.var(ride.twist[:, 2]))),
    "linear_velocity_variance_underway": _comfort(
        "variance of speed until the goal", "m²/s²", digits=4,
        compute=lambda ride: float(np.var(motion.underway(ride)[:, 0])),
    ),
    "angular_velocity_variance_underway": _comfort(
        "variance of turn rate until the goal", "rad²/s²", digits=4,
        compute=lambda ride: float(np.var(motion.underway(ride)[:, 2])),
    ),
    "heading_change": _comfort("total heading change", "rad", digits=2,
                               compute=motion.heading_change),
    "acceleration_max": _comfort(
        "largest acceleration", "m/s²",
        compute=lambda ride: float(np.abs(motion.acceleration(ride)).max(initial=0.0)),
    ),
    "acceleration_rms": _comfort("RMS acceleration", "m/s²",
                                 compute=lambda ride: motion.rms(motion.acceleration(ride))),
    "jerk_max": _comfort("largest jerk", "m/s³",
                         compute=lambda ride: float(np.abs(motion.jerk(ride)).max(initial=0.0))),
    "jerk_rms": _comfort("RMS jerk", "m/s³", compute=lambda ride: motion.rms(motion.jerk(ride))),
    "jerk_felt_rms": _comfort("RMS jerk at the seat", "m/s³",
                              compute=lambda ride: motion.rms(comfort.felt_jerk(ride))),
    "jerk_felt_p99": _comfort("99th percentile of the jerk at the seat", "m/s³",
                              compute=comfort.felt_jerk_p99),
    "stop_rate": _comfort("stops", "1/min", digits=1, compute=comfort.stop_rate),
    "short_stops": _comfort("stops under 0.3 s", "", digits=1, compute=comfort.short_stops),
    "braking_time": _comfort("time braking", "s", better=0, digits=1,
                             compute=comfort.braking_time),
    "hard_braking": _comfort("time braking above 0.8 m/s²", PERCENT, digits=1,
                             compute=comfort.hard_braking),
    "gentle_braking": _comfort("share of braking up to 0.8 m/s²", PERCENT, better=1, digits=1,
                               compute=comfort.gentle_braking),
    "authority": _rider("mean authority of the rider", PERCENT, digits=1,
                        compute=lambda ride: float(ride.eta.mean())),
    "agreement": _rider("agreement of requested and executed command", "", 1,
                        compute=rider.agreement),
    "disagreement": _rider("difference of requested and executed command", "", -1,
                           compute=rider.disagreement),
    "intervention_share": _rider("time with an intervention", PERCENT, digits=1,
                                 compute=rider.intervention_share),
    "conflict_share": _rider("time turning against the rider", PERCENT, -1, digits=1,
                             compute=rider.conflict_share),
    "rider_effort": _rider("movement of the stick", "full deflections", -1, compute=rider.effort),
    "rider_reversals": _rider("stick reversals", "1/min", -1, compute=rider.reversals),
    "tight_speed": _rider("speed asked for within 0.3 m of walls", "m/s",
                          compute=rider.tight_speed),
    "turn_share": _rider("turn asked for, 90th percentile", PERCENT, digits=1,
                         compute=rider.turn_share),
    "steadiness": _rider("steadiness of the hand", PERCENT, digits=1, compute=rider.steadiness),
    "rating": RideMeasure("rating, 1 to 5", "", 1, Family.OPINION),
    "solve_median_ms": _milliseconds("planning time, median"),
    "solve_p99_ms": _milliseconds("planning time, 99th percentile"),
    "tick_median_ms": _milliseconds("tick time, median"),
}  # fmt: skip
"""Name → measure, in the order of a table."""

RIDE_MEASURES = tuple(name for name, each in MEASURES.items() if each.compute is not None)
"""Names of the measures of one ride."""
PROXIES = tuple(name for name, each in MEASURES.items() if each.family is Family.RIDER)
"""Measures that stand in for the opinion of a rider."""
REPORTED = (
    "reached", "person_collision", "wall_collision", "time", "time_ratio", "path_length",
    "min_distance", "linear_velocity_variance", "angular_velocity_variance",
)  # fmt: skip
"""Default columns of a report: Xu et al., Table 3, and the outcome."""


def measure(ride: Ride) -> dict[str, float]:
    """All measures of a ride by name; NaN where one does not apply."""
    return {name: MEASURES[name].of(ride) for name in RIDE_MEASURES}


def measure_info(name: str) -> RideMeasure:
    """Entry of a measure; a column that is not in the table is labelled by its own name."""
    return MEASURES.get(name, RideMeasure(name))


def measure_table() -> list[dict[str, Any]]:
    """Table of the measures of a ride as plain data, for the page and other programs.

    A unit of ``%`` belongs to a value of 0…1.
    """
    return [
        {
            "name": name,
            "label": each.label,
            "unit": each.unit,
            "better": each.better,
            "family": each.family.value,
            "digits": each.digits,
        }
        for name, each in MEASURES.items()
        if each.compute is not None
    ]


def timing(ride: Ride) -> dict[str, dict[str, float]]:
    """Thread CPU time of a tick by stage, s: median, 99th percentile, maximum, and first tick.

    The first three leave out the first tick, which includes compilation.
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
