"""Recordings: bags and clouds in, observations out; walks that others noted down."""

from cohelm.recordings.api import Frame, Labels, Recording
from cohelm.recordings.trajectories import Trajectories, read_groups, read_trajectories

__all__ = [
    "Frame",
    "Labels",
    "Recording",
    "Trajectories",
    "read_groups",
    "read_trajectories",
]
