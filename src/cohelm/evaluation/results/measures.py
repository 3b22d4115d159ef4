"""What the columns of a ride mean: heading, unit, which way is better, how they are summed up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum


class Family(StrEnum):
    """What a measure speaks of."""

    OUTCOME = "outcome"
    SAFETY = "people and walls"
    EFFICIENCY = "time and way"
    COMFORT = "comfort"
    RIDER = "stand-ins for the rider's opinion"
    """Computed from stick and wheels: nobody was asked."""
    ASKED = "what people said"
    PROGRAM = "the program"


@dataclass(frozen=True)
class Measure:
    """How a column is shown and judged."""

    head: str
    unit: str = ""
    better: int = 0
    """1: more is better, −1: less; 0: neither."""
    family: Family = Family.EFFICIENCY
    share: bool = False
    """Each ride has it or has it not: shares of rides are told, not medians."""
    digits: int = 2
    timing: bool = False
    """Differs between two runs of the same ride."""

    @property
    def label(self) -> str:
        """Heading with its unit: ``time, s``."""
        unit = "% of rides" if self.share else self.unit
        return f"{self.head}, {unit}" if unit else self.head


def _share(head: str, better: int, family: Family = Family.OUTCOME) -> Measure:
    return Measure(head, "", better, family, share=True, digits=0)


def _safe(head: str, unit: str, better: int, digits: int = 2) -> Measure:
    return Measure(head, unit, better, Family.SAFETY, digits=digits)


def _comfort(head: str, unit: str, better: int = -1, digits: int = 3) -> Measure:
    return Measure(head, unit, better, Family.COMFORT, digits=digits)


def _rider(head: str, unit: str, better: int = 0) -> Measure:
    return Measure(head, unit, better, Family.RIDER)


def _milliseconds(head: str) -> Measure:
    return Measure(head, "ms", -1, Family.PROGRAM, timing=True)


KNOWN: Mapping[str, Measure] = {
    "reached": _share("reached", 1),
    "hit_moving": _share("hit a person while moving", -1),
    "hit_standing": _share("walked into while it stood", -1),
    "hit_wall": _share("hit a wall", -1),
    "broke_off": _share("broke off", -1, Family.PROGRAM),
    "time": Measure("time", "s", -1),
    "time_ratio": Measure("time ÷ time alone", "", -1),
    "path_length": Measure("length", "m", -1),
    "path_length_short": Measure("length to 0.3 m before the goal", "m", -1),
    "spl": Measure("success × route ÷ length", "", 1),
    "stalled_time": Measure("stood", "s", -1),
    "stops": Measure("stops", "", -1, digits=1),
    "replan_count": Measure("new routes", "", 0, digits=1),
    "path_error": Measure("mean distance from the route", "m", 0),
    "path_hausdorff": Measure("largest distance from the route", "m", 0),
    "preference_distance": Measure("missed a wished point by", "m", -1),
    "time_alone": Measure("time alone", "s", 0),
    "min_distance": _safe("least gap to a person", "m", 1),
    "mean_distance": _safe("mean gap to the nearest person", "m", 1),
    "collision_speed": _safe("speed at a touch", "m/s", -1),
    "collisions_person": _safe("people touched", "", -1),
    "collisions_wall": _safe("touches of a wall", "", -1),
    "standing_contacts": _safe("touched by people while it stood", "", -1),
    "wall_distance": _safe("least gap to a wall", "m", 1),
    "time_to_collision": _safe("least time to a touch", "s", 1),
    "encounters": _safe("people within 2 m", "", 0, 1),
    "proxemics_intimate": _safe("share of time below 0.45 m", "", -1, 3),
    "proxemics_personal": _safe("share of time from 0.45 to 1.2 m", "", 0, 3),
    "proxemics_social": _safe("share of time from 1.2 to 3.6 m", "", 0, 3),
    "social_space_intrusion": _safe("in personal space, depth × time", "s", -1),
    "social_space_intrusion_share": _safe("share of time deep in personal space", "", -1, 3),
    "group_space_intrusion": _safe("in a group's space, depth × time", "s", -1),
    "group_space_intrusion_share": _safe("share of time deep in a group's space", "", -1, 3),
    "pedestrian_delay": _safe("people later than without the chair", "s", -1),
    "pedestrian_deviation": _safe("people off their way without the chair", "m", -1),
    "beside_share": _safe("share of time beside the companion", "", 1, 3),
    "linear_velocity_variance": _comfort("variance of speed", "m²/s²", digits=4),
    "angular_velocity_variance": _comfort("variance of turn rate", "rad²/s²", digits=4),
    "linear_velocity_variance_underway": _comfort(
        "variance of speed, until the goal", "m²/s²", digits=4
    ),
    "angular_velocity_variance_underway": _comfort(
        "variance of turn rate, until the goal", "rad²/s²", digits=4
    ),
    "heading_change": _comfort("turning added up", "rad", digits=2),
    "acceleration_max": _comfort("largest acceleration", "m/s²"),
    "acceleration_rms": _comfort("acceleration, rms", "m/s²"),
    "jerk_max": _comfort("largest jerk", "m/s³"),
    "jerk_rms": _comfort("jerk, rms", "m/s³"),
    "authority": _rider("η, mean", ""),
    "agreement": _rider("agreement", "", 1),
    "disagreement": _rider("disagreement", "", -1),
    "intervention_share": _rider("share of time it steps in", ""),
    "fight_rate": _rider("share of time they turn against each other", "", -1),
    "rider_effort": _rider("movement of the stick", "deflections", -1),
    "rider_reversals": _rider("stick reversals", "1/min", -1),
    "rating": Measure("rating by a person, 1 to 5", "", 1, Family.ASKED),
    "solve_median_ms": _milliseconds("a plan's time, median"),
    "solve_p99_ms": _milliseconds("a plan's time, 99 %"),
    "tick_median_ms": _milliseconds("a tick's time, median"),
}
"""Column → what it means. Columns that are not here are shown under their own name."""

PROXIES = tuple(name for name, each in KNOWN.items() if each.family is Family.RIDER)
"""What stands in for a rider's opinion, and is none."""
SHOWN = (
    "reached", "hit_moving", "hit_wall", "time", "time_ratio", "path_length", "min_distance",
    "linear_velocity_variance", "angular_velocity_variance",
)  # fmt: skip
"""In the tables of a report, where no others are asked for: Xu et al., Table 3, and the outcome."""


def measure(name: str) -> Measure:
    """What a column means; one that nobody knows under its own name."""
    return KNOWN.get(name, Measure(name))
