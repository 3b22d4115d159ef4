"""What the chair's sensors see of the true world."""

from cohelm.simulation.sensors.cloud import Sweep, scan_cloud, sweep_cloud, visible_shares
from cohelm.simulation.sensors.figures import Bodies
from cohelm.simulation.sensors.laser import sweep
from cohelm.simulation.sensors.localisation import Localisation, Odometry
from cohelm.simulation.sensors.raycast import cast
from cohelm.simulation.sensors.scenery import LEVEL, Floor, Scenery

__all__ = [
    "LEVEL",
    "Bodies",
    "Floor",
    "Localisation",
    "Odometry",
    "Scenery",
    "Sweep",
    "cast",
    "scan_cloud",
    "sweep",
    "sweep_cloud",
    "visible_shares",
]
