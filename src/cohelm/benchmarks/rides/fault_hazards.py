"""Hazards of each fault for the table of failure modes: effect, and what remains."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Hazard(NamedTuple):
    """Entry of a failure mode."""

    effect: str
    residual: str
    detectable: bool = True
    """False: no redundant input reveals it in time, for the reason in ``residual``."""
    except_at: tuple[float, ...] = ()
    """Magnitudes at which it is not reliably detectable either, for the same reason."""

    def detectable_at(self, magnitude: float) -> bool:
        """Check that a magnitude is detectable."""
        return self.detectable and magnitude not in self.except_at


_BRAKING = "the distance of braking from the speed at the onset"
_UNSTOPPABLE = (
    "the wheels no longer obey: detected, but only a relay in the motor supply stops them"
)

HAZARDS: Mapping[str, Hazard] = MappingProxyType(
    {
        "scan_frozen": Hazard("people and chair seem to stand still", _BRAKING),
        "scan_constant": Hazard("nothing real is seen", _BRAKING),
        "scan_nan": Hazard("nothing is seen", _BRAKING),
        "scan_blind": Hazard("nothing is seen ahead", "gaps narrower than 9° stay unnoticed"),
        "scan_free_sector": Hazard(
            "people ahead are missed",
            "in halls wider than the scanner's range only who was seen before within 6 m tells a "
            "lost beam from a free path",
            except_at=(20.0, 45.0),
        ),
        "scan_free_beams": Hazard("thin things are missed", "25 % lost beams may pass as glass"),
        "scan_scaled": Hazard("people seem farther or nearer", "scales within 10 % near walls"),
        "scan_spots": Hazard("phantom obstacles", "too many stops; never a missed person", False),
        "scan_multipath": Hazard("ghost spaces behind walls", "people are still seen in front"),
        "scan_glass": Hazard("walls are missed", "panes narrower than 9° ahead"),
        "scan_sunlight": Hazard("a sector is dazzled", "sectors narrower than 9° ahead"),
        "scan_silent": Hazard("nothing new is seen", _BRAKING),
        "scan_delayed": Hazard("people are seen late", "0.2 s is within the gate's bound", False),
        "scan_restamped": Hazard(
            "people are seen late", "0.2 s shifts the scan less than the map's tolerance"
        ),
        "scan_out_of_order": Hazard(
            "every second sweep is dropped", "people are seen 0.1 s later", False
        ),
        "scan_mirrored": Hazard("left and right change places", _BRAKING),
        "scan_rotated": Hazard("everything is seen in a wrong direction", "turns below 4°"),
        "pose_silent": Hazard("place unknown", _BRAKING),
        "pose_frozen": Hazard("place wrong", _BRAKING),
        "pose_nan": Hazard("place unknown", _BRAKING),
        "pose_jump": Hazard("walls are expected in wrong places", "live obstacles still count"),
        "pose_drift": Hazard("walls are expected in wrong places", "0.2 m of drift, driven slowly"),
        "pose_turn_drift": Hazard("the chair turns off its path", "4° of drift, driven slowly"),
        "pose_overconfident": Hazard("walls are expected in wrong places", "errors below 0.2 m"),
        "kidnapped": Hazard(
            "walls are expected in wrong places", "along featureless corridors; below 0.3 m"
        ),
        "twist_silent": Hazard("speed unknown", _BRAKING),
        "twist_frozen": Hazard("speed wrong", "until the speed should change"),
        "twist_nan": Hazard("speed unknown", _BRAKING),
        "twist_zero": Hazard("stopping distance underrated", _BRAKING),
        "twist_scaled": Hazard("stopping distance wrong", "scales within 20 % take seconds"),
        "wheel_slip": Hazard("the chair moves less than its wheels", "slip of 20 % takes seconds"),
        "command_stuck": Hazard("the chair drives on", _UNSTOPPABLE, False),
        "command_dead": Hazard("the chair stops", "none: it stands"),
        "command_delayed": Hazard(
            "late braking",
            "0.15 s is within the gate's reaction time; longer ones show only when "
            "the speed changes",
            False,
        ),
        "command_dropped": Hazard(
            "late braking",
            "shows only when the speed changes; nine of ten dropped act as a delay",
            False,
        ),
        "command_scaled": Hazard("too fast, or in reverse", _UNSTOPPABLE, False),
        "command_flipped": Hazard("turns in the wrong direction", _BRAKING),
        "motor_weak": Hazard(
            "the chair pulls to one side", "control steers a loss of 30 % out", detectable=False
        ),
        "brake_slow": Hazard(
            "stopping distance too long", "shows only in hard braking, when it is needed", False
        ),
        "battery_sag": Hazard("slower than commanded", "none: it is slower"),
        "rider_silent": Hazard("the chair drives on", _BRAKING),
        "rider_nan": Hazard("the chair drives on", _BRAKING),
        "rider_stuck": Hazard(
            "the chair drives where nobody steers",
            "a key is as constant as a broken stick: only the gate stops before obstacles, and "
            "8 s of standing against one",
            False,
        ),
        "rider_repeated": Hazard("the chair drives where nobody steers", "as a stuck stick", False),
        "rider_off_centre": Hazard(
            "the chair veers", "looks like a rider who steers a little: only the gate stops", False
        ),
        "people_ghost": Hazard("the chair waits for nobody", "looks like a person", False),
        "people_lost": Hazard(
            "a person is not seen",
            "noticed if the person was seen free within 6 m before; else no sensor has a trace",
            False,
        ),
        "people_swapped": Hazard("predictions restart", "ids are not used for contact", False),
        "late": Hazard("old decisions", _BRAKING),
        "clock_backwards": Hazard("ages are wrong", _BRAKING),
        "clock_forwards": Hazard(
            "all input seems old", "steps below 0.2 s look like latency", True
        ),
    }
)
