from .control.limits import PACES, LimitsLoosened
from .drive import Drive, DriveHealth, DriveSetup

__all__ = ["PACES", "Drive", "DriveHealth", "DriveSetup", "LimitsLoosened"]
