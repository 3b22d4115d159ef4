"""Published local planners for comparison; one file each, each an entry point."""

from cohelm.control.baselines.apf import Apf
from cohelm.control.baselines.dwa import Dwa
from cohelm.control.baselines.mpc import Mpc
from cohelm.control.baselines.mpc_dcbf import MpcDcbf
from cohelm.control.baselines.path_follower import PathFollower, without_people
from cohelm.control.baselines.social_mpc import SocialMpc
from cohelm.control.baselines.teb import Teb

__all__ = ["Apf", "Dwa", "Mpc", "MpcDcbf", "PathFollower", "SocialMpc", "Teb", "without_people"]
