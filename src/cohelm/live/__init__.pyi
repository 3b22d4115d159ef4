from .commands import NextStorey
from .control.limits import PACES, LimitsLoosened
from .drive import Drive, DriveHealth, DriveSetup
from .floor_model import DriveStorey

__all__ = [
    "PACES",
    "Drive",
    "DriveHealth",
    "DriveSetup",
    "DriveStorey",
    "LimitsLoosened",
    "NextStorey",
]
