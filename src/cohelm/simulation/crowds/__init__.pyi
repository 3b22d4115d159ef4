from .behaviours import (
    Aggressive,
    Distracted,
    Inattentive,
    TurningBack,
    prepare_crowd,
)
from .orca import Orca
from .social_force import SocialForce

__all__ = [
    "Aggressive",
    "Distracted",
    "Inattentive",
    "Orca",
    "SocialForce",
    "TurningBack",
    "prepare_crowd",
]
