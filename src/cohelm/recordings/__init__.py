"""Recordings: bags and clouds in, observations out; rides in and out; walks that others noted."""

from cohelm.recordings.api import Frame, Labels, Recording
from cohelm.recordings.opening import open_recording
from cohelm.recordings.ride import RideFacts, RideTick, made_of
from cohelm.recordings.ride_reading import RecordedRide
from cohelm.recordings.ride_recorder import RideRecorder
from cohelm.recordings.trajectories import Trajectories, read_groups, read_trajectories

__all__ = [
    "Frame",
    "Labels",
    "RecordedRide",
    "Recording",
    "RideFacts",
    "RideRecorder",
    "RideTick",
    "Trajectories",
    "made_of",
    "open_recording",
    "read_groups",
    "read_trajectories",
]
