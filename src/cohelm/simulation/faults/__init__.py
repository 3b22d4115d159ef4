"""Faults of real chairs, injected between world and navigator."""

from cohelm.simulation.faults.api import FaultKind
from cohelm.simulation.faults.fault import Fault
from cohelm.simulation.faults.injection import FaultInjector
from cohelm.simulation.faults.kinds import FAULT_KINDS

__all__ = ["FAULT_KINDS", "Fault", "FaultInjector", "FaultKind"]
