"""LUCI: a power wheelchair with LUCI's sensors and its shared-control input, over gRPC.

    rider's joystick ─► UserJoystickStream ─► observation ─► navigator
                                                                │
    motors ◄─ LUCI's own collision avoidance ◄─ JsOverride ◄────┘  20 a second, source SharedRemote

LUCI keeps its own protection: it slows what it gets. Needs the extra ``luci``.
"""

from cohelm.platforms.luci.parameters import LuciParameters
from cohelm.platforms.luci.platform import Luci, LuciPlatform

__all__ = ["Luci", "LuciParameters", "LuciPlatform"]
