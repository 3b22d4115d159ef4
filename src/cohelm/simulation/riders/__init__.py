"""Simulated riders: what a hand does on the stick."""

from cohelm.simulation.riders.ideal import Ideal
from cohelm.simulation.riders.idle import Idle
from cohelm.simulation.riders.none import NoRider
from cohelm.simulation.riders.nudge import Nudge

__all__ = ["Ideal", "Idle", "NoRider", "Nudge"]
