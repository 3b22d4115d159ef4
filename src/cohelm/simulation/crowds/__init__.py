"""Pedestrian models."""

from cohelm.simulation.crowds.behaviours import (
    Aggressive,
    Distracted,
    Inattentive,
    TurningBack,
    prepare_crowd,
)
from cohelm.simulation.crowds.orca import Orca
from cohelm.simulation.crowds.social_force import SocialForce

__all__ = [
    "Aggressive",
    "Distracted",
    "Inattentive",
    "Orca",
    "SocialForce",
    "TurningBack",
    "prepare_crowd",
]
