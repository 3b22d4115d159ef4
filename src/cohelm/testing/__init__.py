"""Conformance checks of plugins: the contract of each Protocol as code, for authors of plugins.

One function per Protocol; each takes a ready part and raises :class:`ConformanceError` with the
violated rule. In a test::

    def test_my_planner_conforms():
        check_local_planner(MyPlanner(MyPlanner.Parameters()))

Hypothesis strategies for the values are in ``cohelm.testing.strategies`` (needs hypothesis).
"""

from cohelm.testing.conformance import ConformanceError
from cohelm.testing.global_planners import check_global_planner
from cohelm.testing.groups import check_group_detector
from cohelm.testing.kinematics import check_kinematics
from cohelm.testing.local_planners import check_local_planner
from cohelm.testing.pedestrians import check_pedestrian_model, check_rider
from cohelm.testing.perception import (
    check_cloud_detector,
    check_detector,
    check_tracker,
)
from cohelm.testing.platforms import check_open_platform, check_platform
from cohelm.testing.prediction import check_predictor
from cohelm.testing.social import check_social_model

CHECKS = {
    "cloud_detectors": check_cloud_detector,
    "detectors": check_detector,
    "group_detectors": check_group_detector,
    "global_planners": check_global_planner,
    "kinematics": check_kinematics,
    "local_planners": check_local_planner,
    "pedestrian_models": check_pedestrian_model,
    "platforms": check_platform,
    "predictors": check_predictor,
    "riders": check_rider,
    "social_models": check_social_model,
    "trackers": check_tracker,
}
"""Kind of part, as in ``plugins.GROUPS`` → its check."""

__all__ = [
    "CHECKS",
    "ConformanceError",
    "check_cloud_detector",
    "check_detector",
    "check_global_planner",
    "check_group_detector",
    "check_kinematics",
    "check_local_planner",
    "check_open_platform",
    "check_pedestrian_model",
    "check_platform",
    "check_predictor",
    "check_rider",
    "check_social_model",
    "check_tracker",
]
