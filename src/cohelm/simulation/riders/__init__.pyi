from .disturbances import (
    Biased,
    Delayed,
    Dropout,
    Laggy,
    Noisy,
    Tremor,
    Uncooperative,
)
from .ideal import Ideal
from .limited import EightDirections, LookingAway
from .one_switch import OneSwitch
from .passive import Idle, NoRider, Nudge
from .supervision import Reluctant, Watchful

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
