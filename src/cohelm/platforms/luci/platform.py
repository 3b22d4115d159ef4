"""LUCI chair as a platform."""

from __future__ import annotations

import logging
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from cohelm.errors import PlatformError
from cohelm.messages import Decision, Observation, PointCloud, RiderCommand
from cohelm.platforms.api import Capabilities
from cohelm.platforms.luci.conversions import WheelOdometry, advanced, points_of, stick_of
from cohelm.platforms.luci.parameters import LuciParameters
from cohelm.scenarios import RideSetup

if TYPE_CHECKING:
    from cohelm.platforms.luci.client import LuciClient

NEVER = -10.0
"""Time of an input that never came, s: older than every limit."""
MAX_CLOUDS = 16
"""Maximum number of clouds kept until the next observation."""
_POLL = 0.05  # s
_log = logging.getLogger(__name__)


class Luci:
    """Chair with LUCI: joystick, cameras, wheel encoders and the shared-control input."""

    simulated = False

    class Parameters(LuciParameters):
        """Address, scaling, wheels and cameras."""

    def __init__(self, parameters: LuciParameters) -> None:
        self.parameters = parameters

    def open(self, setup: RideSetup) -> LuciPlatform:
        """Wait for all inputs, then become the chair's input.

        Raises:
            PlatformError: It does not answer, or an input does not come; it says which.
        """
        try:
            from cohelm.platforms.luci.client import LuciClient  # noqa: PLC0415 # needs the extra
        except ImportError as cause:
            text = f"needs the extra 'luci' ({cause}): pip install 'cohelm[luci,web]'"
            raise PlatformError(text) from None
        client = LuciClient(self.parameters)
        try:
            return LuciPlatform(client, self.parameters)
        except BaseException:
            client.close()
            raise


class LuciPlatform:
    """LUCI chair with all inputs.

    Args:
        client: Connection; the platform closes it.
        parameters: Wheels and cameras.

    Raises:
        PlatformError: An input does not come.
    """

    def __init__(self, client: LuciClient, parameters: LuciParameters) -> None:
        self._client, self._parameters = client, parameters
        self._capabilities = Capabilities(name=f"LUCI chair at {parameters.host}")
        self._began, self._lock, self._closed = time.monotonic(), threading.Lock(), False
        self._odometry: WheelOdometry | None = None
        self._rider: RiderCommand | None = None
        self._clouds: list[PointCloud] = []
        self._seen: set[str] = set()
        client.listen("UserJoystickStream", self._take_joystick)
        client.listen("EncoderStream", self._take_angles)
        client.listen("DecimatedCameraStream", self._take_points)
        self._wait()
        client.take_over()

    @property
    def capabilities(self) -> Capabilities:
        """Nothing beyond driving."""
        return self._capabilities

    def observe(self) -> Observation:
        """Return the newest inputs; the odometry is lost while LUCI does not answer."""
        with self._lock:
            now, odometry, rider = self._now(), self._odometry, self._rider
            clouds, self._clouds = tuple(self._clouds), []
        time_ = NEVER if odometry is None or self._client.late else odometry.time
        if rider is not None and not self._parameters.joystick.repeats:
            rider = RiderCommand(heartbeat=time_, deflection=rider.deflection)
        return Observation(
            time=now,
            pose=np.zeros(3) if odometry is None else np.array(odometry.pose),
            pose_time=time_,
            twist=np.zeros(3) if odometry is None else odometry.twist,
            twist_time=time_,
            clouds=clouds,
            rider=rider,
        )

    def apply(self, decision: Decision) -> None:
        """Send a command to the chair."""
        self._client.send(decision.twist)

    def close(self) -> None:
        """Stop, and give the chair back to its own joystick."""
        if not self._closed:
            self._closed = True
            self._client.close()

    def _now(self) -> float:
        return time.monotonic() - self._began

    def _wait(self) -> None:
        needed = {
            "joystick": "it stands still? set joystick.repeats: false",
            "encoders": "cohelm needs LUCI's wheel encoders",
            "cameras": "are all of LUCI's cameras on?",
        }
        if not self._parameters.joystick.repeats:
            del needed["joystick"]
        end = time.monotonic() + self._parameters.wait
        while not self._seen >= set(needed) and time.monotonic() < end:
            time.sleep(_POLL)
        missing = [f"no {name} ({why})" for name, why in needed.items() if name not in self._seen]
        if missing:
            raise PlatformError(f"{'; '.join(missing)} within {self._parameters.wait:g} s")

    def _take_joystick(self, message: Any) -> None:
        with self._lock:
            now = self._now()
            self._rider = RiderCommand(heartbeat=now, deflection=np.array(stick_of(message)))
            self._seen.add("joystick")

    def _take_angles(self, message: Any) -> None:
        angles = float(message.left_angle), float(message.right_angle)
        with self._lock:
            now = self._now()
            try:
                self._odometry = advanced(self._odometry, angles, now, self._parameters.wheels)
            except ValueError as error:  # the odometry gets old, and the chair stops
                _log.warning("ignored: %s", error)
                return
            self._seen.add("encoders")

    def _take_points(self, message: Any) -> None:
        points, camera = points_of(message), self._parameters.camera
        with self._lock:
            mount = np.array(camera.mount)
            cloud = PointCloud(
                time=self._now(), mount=mount, points=points, range_max=camera.range_max
            )
            self._clouds = [*self._clouds, cloud][-MAX_CLOUDS:]
            self._seen.add("cameras")
