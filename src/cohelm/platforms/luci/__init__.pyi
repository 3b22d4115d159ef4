from .parameters import LuciParameters
from .platform import Luci, LuciPlatform

__all__ = ["Luci", "LuciParameters", "LuciPlatform"]
