"""People in the clouds of 3-D sensors."""

from __future__ import annotations

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.maps import DistanceField
from cohelm.messages import PointCloud
from cohelm.perception.api import Detections


class CloudClusters:
    """Finds nobody yet."""

    class Parameters(Model):
        """None."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def detect(
        self, clouds: tuple[PointCloud, ...], X_MR: Floats, walls: DistanceField
    ) -> Detections:
        """See :meth:`CloudDetector.detect`."""
        return Detections.nothing(clouds[0].time, X_MR[0, :2])
