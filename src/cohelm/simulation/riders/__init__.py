"""Simulated riders: models of the input to the stick."""

from cohelm.simulation.riders.disturbances import (
    Biased,
    Delayed,
    Dropout,
    Laggy,
    Noisy,
    Tremor,
    Uncooperative,
)
from cohelm.simulation.riders.ideal import Ideal
from cohelm.simulation.riders.limited import EightDirections, LookingAway
from cohelm.simulation.riders.one_switch import OneSwitch
from cohelm.simulation.riders.passive import Idle, NoRider, Nudge
from cohelm.simulation.riders.supervision import Reluctant, Watchful

__all__ = [
    "Biased",
    "Delayed",
    "Dropout",
    "EightDirections",
    "Ideal",
    "Idle",
    "Laggy",
    "LookingAway",
    "NoRider",
    "Noisy",
    "Nudge",
    "OneSwitch",
    "Reluctant",
    "Tremor",
    "Uncooperative",
    "Watchful",
]
