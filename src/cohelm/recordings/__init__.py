"""Recordings: bags and clouds in, observations out; walks that others noted down."""

from cohelm.recordings.api import Frame, Labels, Recording
from cohelm.recordings.opening import open_recording
from cohelm.recordings.trajectories import Trajectories, read_groups, read_trajectories

__all__ = [
    "Frame",
    "Labels",
    "Recording",
    "Trajectories",
    "open_recording",
    "read_groups",
    "read_trajectories",
]
