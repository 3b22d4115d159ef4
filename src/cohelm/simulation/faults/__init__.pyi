from .api import FaultKind
from .fault import Fault
from .injection import FaultInjector
from .kinds import FAULT_KINDS

__all__ = ["FAULT_KINDS", "Fault", "FaultInjector", "FaultKind"]
