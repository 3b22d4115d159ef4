from .api import Frame, Labels, SensorRecording
from .opening import open_recording
from .pedestrians.trajectories import Trajectories, read_groups, read_trajectories
from .rides.reader import RecordedRide
from .rides.recorder import RideRecorder
from .rides.ride import RideFacts, RideTick, digest_of

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
