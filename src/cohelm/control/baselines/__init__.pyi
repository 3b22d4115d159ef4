from .apf import Apf
from .dwa import Dwa
from .mpc import Mpc
from .mpc_dcbf import MpcDcbf
from .path_follower import PathFollower, without_people
from .social_mpc import SocialMpc
from .teb import Teb

__all__ = ["Apf", "Dwa", "Mpc", "MpcDcbf", "PathFollower", "SocialMpc", "Teb", "without_people"]
