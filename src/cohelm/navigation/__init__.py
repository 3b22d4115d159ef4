"""The navigator: where the stages meet."""

from cohelm.navigation.navigator import Navigator
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.tick import Memory, Tick

__all__ = ["Memory", "Navigator", "NavigatorSetup", "Tick"]
