"""All kinds of faults by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cohelm.simulation.faults.api import FaultKind
from cohelm.simulation.faults.clock import CLOCK
from cohelm.simulation.faults.drive import DRIVE
from cohelm.simulation.faults.people import PEOPLE
from cohelm.simulation.faults.pose import POSE
from cohelm.simulation.faults.rider import RIDER
from cohelm.simulation.faults.scan_timing import SCAN_TIMING
from cohelm.simulation.faults.scan_values import SCAN_VALUES
from cohelm.simulation.faults.twist import TWIST

FAULT_KINDS: Mapping[str, FaultKind] = MappingProxyType(
    {**SCAN_VALUES, **SCAN_TIMING, **POSE, **TWIST, **DRIVE, **RIDER, **PEOPLE, **CLOCK}
)
"""Name → kind, sensors first."""
