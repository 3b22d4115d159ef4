"""Recordings: bags and point clouds, recorded rides, and pedestrian trajectories."""

from cohelm.recordings.api import Frame, Labels, SensorRecording
from cohelm.recordings.opening import open_recording
from cohelm.recordings.pedestrians.trajectories import Trajectories, read_groups, read_trajectories
from cohelm.recordings.rides.reader import RecordedRide
from cohelm.recordings.rides.recorder import RideRecorder
from cohelm.recordings.rides.ride import RideFacts, RideTick, digest_of

__all__ = [
    "Frame",
    "Labels",
    "RecordedRide",
    "RideFacts",
    "RideRecorder",
    "RideTick",
    "SensorRecording",
    "Trajectories",
    "digest_of",
    "open_recording",
    "read_groups",
    "read_trajectories",
]
