"""Other people's local planners, to compare with; one file each, each an entry point."""

from cohelm.control.baselines.dwa import Dwa
from cohelm.control.baselines.path_follower import PathFollower, without_people

__all__ = ["Dwa", "PathFollower", "without_people"]
