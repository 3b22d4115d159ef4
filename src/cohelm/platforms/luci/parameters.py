"""Parameters of a LUCI chair: the part ``platform:`` of its file."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from cohelm.config import Model


class Scaling(Model):
    """Speeds of the chair at full deflection, in the drive profile that is used with cohelm."""

    forward_speed: float = Field(1.0, gt=0.05, le=4.0)
    """Speed at +100, m/s; assumed, measure it."""
    reverse_speed: float = Field(0.5, gt=0.05, le=4.0)
    """Speed at −100, m/s; assumed, measure it."""
    turn_rate: float = Field(1.0, gt=0.05, le=4.0)
    """Turn rate at ±100, rad/s; assumed, measure it."""
    start: int = Field(0, ge=0, le=50)
    """Deflection at which the chair begins to move, of 100."""
    limit: int = Field(100, ge=10, le=100)
    """Maximum deflection that is sent, of 100."""
    centre: Literal[0, 100] = 100
    """Number that LUCI takes as a centred remote joystick. LUCI's own client adds 100 to its
    numbers of −100…100; a wrong centre is full speed, so lift the wheels for the first drive."""


class Wheels(Model):
    """Drive wheels with encoders, as LUCI's encoder library describes them."""

    circumference: float = Field(1.12, gt=0.2, le=3.0)
    """m; assumed, 14-inch wheels."""
    track: float = Field(0.56, gt=0.2, le=1.5)
    """Distance between the wheels, m; assumed."""
    gear_ratio: float = Field(1.0, gt=0.01, le=100.0)
    """Turns of an encoder per turn of its wheel."""
    left_increases: bool = True
    """True if the left angle increases when the chair drives forward."""
    right_increases: bool = True
    """True if the right angle increases when the chair drives forward."""


class Camera(Model):
    """Point clouds of LUCI's cameras."""

    mount: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """X_RS: x, y, z in m, roll, pitch, yaw in rad; LUCI's points lie in the chair's frame, between
    the drive wheels. Firmware with y ahead needs a yaw of −π/2."""
    range_max: float = Field(4.0, gt=0.5, le=20.0)
    """m; assumed."""


class Joystick(Model):
    """Rider's joystick."""

    repeats: bool = True
    """LUCI sends the position steadily. False: only when it changes; then the encoders tell that
    the connection lives."""


class LuciParameters(Model):
    """Address, scaling, wheels and cameras of a LUCI chair."""

    host: str = Field("192.168.8.125", min_length=1, max_length=200)
    """Address of the chair in its network."""
    port: int = Field(50051, ge=1, le=65535)
    scaling: Scaling = Scaling()
    wheels: Wheels = Wheels()
    camera: Camera = Camera()
    joystick: Joystick = Joystick()
    wait: float = Field(10.0, gt=0.0, le=120.0)
    """Time for all inputs to come when the chair is opened, s."""


MAX_DEFLECTION = 100
"""Number of full deflection."""
MAX_TURN = 2.0 * math.pi
"""Upper bound of a plausible turn rate, rad/s."""
MAX_SPEED = 5.0
"""Upper bound of a plausible speed, m/s."""
