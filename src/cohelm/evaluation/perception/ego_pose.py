"""Poses of the sensors of a recording that has none, estimated from their readings."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from enum import StrEnum

from cohelm.arrays import value
from cohelm.evaluation.perception.ego_motion import EgoMotion, MatchStatus, update_ego_motion
from cohelm.geometry import transform
from cohelm.messages import Observation
from cohelm.recordings import Frame


class PoseSource(StrEnum):
    """Origin of the robot's poses."""

    RECORDED = "recorded"
    ESTIMATED = "estimated from its readings"
    ASSUMED = "assumed at rest"


@value
class PosedFrame:
    """Frame with its pose and its origin."""

    frame: Frame
    source: PoseSource
    ego_motion: EgoMotion | None = None
    """Trajectory so far, where it is estimated."""


class EgoPoses:
    """Adds poses and twists to frames without, and transforms their labels.

    Sensors with unknown mounts have a trajectory each.

    Args:
        at_rest: assume that they are at rest.
    """

    def __init__(self, *, at_rest: bool = False) -> None:
        self._at_rest = at_rest
        self._ego_motions: dict[tuple[str, Hashable], EgoMotion] = {}

    def parts(self, unplaced: str = "") -> int:
        """Count restarts of the estimation; the pose between two parts is unknown.

        Args:
            unplaced: the sensor, see ``Frame``.
        """
        known = self._ego_motions.items()
        return sum(ego_motion.segment for (name, _), ego_motion in known if name == unplaced)

    def __call__(self, frame: Frame) -> PosedFrame:
        """Next frame with its pose."""
        if frame.posed:
            return PosedFrame(frame=frame, source=PoseSource.RECORDED)
        if self._at_rest:
            return PosedFrame(frame=frame, source=PoseSource.ASSUMED)
        observation = frame.observation
        sensor = frame.unplaced, _sensor(observation)
        ego_motion = update_ego_motion(self._ego_motions.get(sensor), observation)
        self._ego_motions[sensor] = ego_motion
        labels = frame.labels
        if labels is not None:
            labels = replace(labels, position=transform(ego_motion.pose, labels.position))
        placed = replace(observation, pose=ego_motion.pose, twist=ego_motion.twist)
        return PosedFrame(
            frame=replace(frame, observation=placed, labels=labels),
            source=PoseSource.ESTIMATED,
            ego_motion=ego_motion,
        )


class EgoPathSummary:
    """Summary of the robot's trajectory in a recording."""

    def __init__(self) -> None:
        self.source = PoseSource.RECORDED
        """Origin of the poses; for a partly recorded trajectory that of the rest."""
        self.length = 0.0
        """Length of the estimated trajectory, m."""
        self.restarts = 0
        """Frames that matched no earlier ones, so that the estimation restarted."""
        self.uncertain = 0
        """Frames that did not determine all directions, or matched nothing for a moment."""

    def add(self, source: PoseSource, ego_motion: EgoMotion | None) -> None:
        """Add one frame."""
        if source is not PoseSource.RECORDED:
            self.source = source
        if ego_motion is None:
            return
        self.restarts += ego_motion.status is MatchStatus.RESTARTED
        self.uncertain += ego_motion.status is MatchStatus.HELD
        self.length = ego_motion.length

    def __str__(self) -> str:
        """Summary in words."""
        if self.source is not PoseSource.ESTIMATED:
            return self.source.value
        parts = [f"{self.length:.1f} m, {self.source.value}" if self.length else "at rest"]
        parts += [f"restarted {self.restarts} times"] * (self.restarts > 0)
        parts += [f"uncertain in {self.uncertain} frames"] * (self.uncertain > 0)
        return ", ".join(parts)


def _sensor(observation: Observation) -> Hashable:
    """Identity of the sensors with these readings."""
    scans = tuple(
        (*each.mount.tolist(), each.angle_min, each.angle_increment, each.range_max)
        for each in observation.scans
    )
    clouds = tuple(tuple(map(str, each.mount.tolist())) for each in observation.clouds)
    return scans, clouds
