"""Compliance of body regions, and the contact limits that forces are set beside.

After the model of ISO/TS 15066:2016, annex A: a body region is a spring with an effective mass; a
contact that lasts is quasi-static, a short one transient with twice the limit. Those limits are for
healthy adults at work, and pressure, edges and falls are left out: a comparison, not an assessment.
The numbers were entered without the standard at hand and wait for a check against its tables.
"""

from __future__ import annotations

from typing import NamedTuple


class BodyRegion(NamedTuple):
    """One region of the body."""

    stiffness: float
    """N/m (ISO/TS 15066, table A.3)."""
    quasi_static: float
    """Limit of the force that lasts, N (ISO/TS 15066, table A.2)."""
    transient: float
    """Factor of that limit for short contacts."""

    @property
    def transient_force(self) -> float:
        """Limit of the force of a short contact, N."""
        return self.transient * self.quasi_static

    @property
    def transient_energy(self) -> float:
        """Energy in the spring at the limit of a short contact, F²/2k, J."""
        return self.transient_force**2 / (2.0 * self.stiffness)


REGIONS = {
    "shank": BodyRegion(60_000.0, 130.0, 2.0),
    "thigh": BodyRegion(50_000.0, 220.0, 2.0),
    "pelvis": BodyRegion(25_000.0, 180.0, 2.0),
    "torso": BodyRegion(25_000.0, 140.0, 2.0),
    "head": BodyRegion(150_000.0, 130.0, 1.0),
    "aid": BodyRegion(100_000.0, 220.0, 2.0),
}
"""Regions by the name of the body part. Torso: as the chest; aid: what a person pushes or sits on,
whose stiffness is assumed and whose limit is that of the thigh."""
QUASI_STATIC = 0.5
"""Duration from which a contact counts as quasi-static, s (ISO/TS 15066, 3.4 and 5.5.5.1)."""
