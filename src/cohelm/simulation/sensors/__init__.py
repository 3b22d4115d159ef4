"""What the chair's sensors see of the true world."""

from cohelm.simulation.sensors.laser import sweep
from cohelm.simulation.sensors.localisation import Localisation, Odometry
from cohelm.simulation.sensors.raycast import cast

__all__ = ["Localisation", "Odometry", "cast", "sweep"]
