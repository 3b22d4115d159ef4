"""Simulated riders: what a hand does on the stick."""

from cohelm.simulation.riders.biased import Biased
from cohelm.simulation.riders.delayed import Delayed
from cohelm.simulation.riders.dropout import Dropout
from cohelm.simulation.riders.ideal import Ideal
from cohelm.simulation.riders.idle import Idle
from cohelm.simulation.riders.laggy import Laggy
from cohelm.simulation.riders.noisy import Noisy
from cohelm.simulation.riders.none import NoRider
from cohelm.simulation.riders.nudge import Nudge
from cohelm.simulation.riders.one_switch import OneSwitch
from cohelm.simulation.riders.reluctant import Reluctant
from cohelm.simulation.riders.tremor import Tremor
from cohelm.simulation.riders.uncooperative import Uncooperative
from cohelm.simulation.riders.watchful import Watchful

__all__ = [
    "Biased",
    "Delayed",
    "Dropout",
    "Ideal",
    "Idle",
    "Laggy",
    "NoRider",
    "Noisy",
    "Nudge",
    "OneSwitch",
    "Reluctant",
    "Tremor",
    "Uncooperative",
    "Watchful",
]
