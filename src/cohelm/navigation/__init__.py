"""The navigator: where the stages meet."""

from cohelm.navigation.navigator import Navigator, NavigatorSetup
from cohelm.navigation.tick import Memory, Tick

__all__ = ["Memory", "Navigator", "NavigatorSetup", "Tick"]
