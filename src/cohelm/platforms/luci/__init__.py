"""LUCI: a power wheelchair with LUCI's sensors and its shared-control input, over gRPC.

    rider's joystick ─► UserJoystickStream ─► observation ─► navigator
                                                                │
    motors ◄─ LUCI's own collision avoidance ◄─ JsOverride ◄────┘  20 a second, source SharedRemote

LUCI keeps its own protection: it slows what it gets. Needs the extra ``luci``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
