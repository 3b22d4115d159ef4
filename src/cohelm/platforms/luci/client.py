"""Connection with LUCI: streams come in, the remote joystick goes out, in threads of their own.

The joystick keeps its pace of 20 messages a second whatever the control loop does:

a new command           sent at once
no new one for 54 ms    the last one again, every 50 ms: below 10 Hz LUCI applies the brakes
none for MAX_AGE        a centred joystick, every 50 ms
"""

from __future__ import annotations

import contextlib
import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import grpc

from cohelm.arrays import Floats
from cohelm.errors import PlatformError
from cohelm.platforms.luci import protocol
from cohelm.platforms.luci.conversions import joystick_of
from cohelm.platforms.luci.parameters import LuciParameters

MAX_AGE = 0.15
"""Age from which a command counts as lost, s."""
PERIOD = 0.05
"""Time between two messages, s."""
_PATIENCE = 0.054
"""Time for which the next command is awaited before the last one is repeated, s."""
_LEAST = 0.046
"""Minimum time between two messages, s."""


class TimedTwist(NamedTuple):
    """Command of the control loop."""

    made_at: float
    """Monotonic time, s."""
    twist: Floats


class Pacer:
    """Newest command, and the time of the next message.

    Args:
        now: Monotonic time, s.
    """

    def __init__(self, now: float) -> None:
        self._command: TimedTwist | None = None
        self._fresh, self._sent_at, self._due = False, -math.inf, now

    def take(self, command: TimedTwist) -> None:
        """Take a command."""
        self._command, self._fresh = command, True

    def timeout(self, now: float) -> float:
        """Time until a message may be due, s."""
        due = self._sent_at + _LEAST if self._fresh else self._due
        return max(min(due, self._due) - now, 0.0)

    def next(self, now: float) -> tuple[bool, Floats | None]:
        """Return True if a message is due, and its twist; None is a centred joystick."""
        fresh = self._fresh and now - self._sent_at >= _LEAST - 1e-9
        if not fresh and now < self._due:
            return False, None
        command, self._fresh, self._sent_at = self._command, False, now
        self._due = now + (_PATIENCE if fresh else PERIOD)
        if command is None or not 0.0 <= now - command.made_at <= MAX_AGE:
            return True, None
        return True, command.twist


CALL_TIMEOUT = 0.1
"""Maximum duration of a joystick message, s."""
LATE_AFTER = 0.2
"""Age of LUCI's last answer from which commands count as lost, s."""
LOST_AFTER = 1.0
"""Age of LUCI's last answer from which the chair counts as lost, s."""
LAST_STOPS = 0.2
"""Time for which a centred joystick follows before the release, s."""
_RELEASE_TIMEOUT = 1.0
"""Maximum duration of a change of the input source, s."""
_log = logging.getLogger(__name__)


class LuciClient:
    """Connection with the chair.

    Args:
        parameters: Address and scaling.

    Raises:
        PlatformError: Nobody answers.
    """

    def __init__(self, parameters: LuciParameters) -> None:
        self._parameters = parameters
        address = f"{parameters.host}:{parameters.port}"
        self._channel = grpc.insecure_channel(address)
        try:
            grpc.channel_ready_future(self._channel).result(timeout=parameters.wait)
        except grpc.FutureTimeoutError:
            self._channel.close()
            raise PlatformError(
                f"no LUCI at {address} within {parameters.wait:g} s: check host, port and network"
            ) from None
        self._streams: list[Any] = []
        self._pacer = Pacer(time.monotonic())
        self._changed = threading.Condition()
        self._ends = self._driving = False
        self._answered_at = time.monotonic()
        self._sender = threading.Thread(target=self._send, name="luci-joystick", daemon=True)

    def listen(self, stream: str, take: Callable[[Any], None]) -> None:
        """Call ``take`` with every message of a stream, in a thread of its own."""
        call = self._channel.unary_stream(
            protocol.path(stream),
            request_serializer=protocol.Empty.SerializeToString,
            response_deserializer=protocol.message(protocol.STREAMS[stream]).FromString,
        )(protocol.Empty())
        self._streams.append(call)
        threading.Thread(
            target=_read, args=(stream, call, take), name=f"luci-{stream}", daemon=True
        ).start()

    def take_over(self) -> None:
        """Become the chair's input, with a centred joystick.

        Raises:
            PlatformError: LUCI refuses.
        """
        try:
            self._select("AddInputSource")
        except grpc.RpcError as error:
            raise PlatformError(f"LUCI refuses the shared input: {_text(error)}") from None
        self._driving, self._answered_at = True, time.monotonic()
        self._sender.start()

    def send(self, twist: Floats) -> None:
        """Send a twist (3,); it holds for 0.15 s.

        Raises:
            PlatformError: LUCI has not answered for a second.
        """
        if time.monotonic() - self._answered_at > LOST_AFTER:
            raise PlatformError("LUCI does not answer")
        with self._changed:
            self._pacer.take(TimedTwist(time.monotonic(), twist))
            self._changed.notify()

    @property
    def late(self) -> bool:
        """True if LUCI does not answer: nobody knows which command holds."""
        return time.monotonic() - self._answered_at > LATE_AFTER

    def close(self) -> None:
        """Centre the joystick, give the chair back to its own one, and end all threads."""
        if self._driving:
            with self._changed:
                self._ends = True
                self._changed.notify()
            self._sender.join()
            end = time.monotonic() + LAST_STOPS
            while time.monotonic() < end:
                self._override(None)
                time.sleep(0.05)
            with contextlib.suppress(grpc.RpcError):  # it is gone, and with it our input
                self._select("RemoveInputSource")
            self._driving = False
        for call in self._streams:
            call.cancel()
        self._channel.close()

    def _send(self) -> None:
        while True:
            with self._changed:
                if self._ends:
                    return
                self._changed.wait(self._pacer.timeout(time.monotonic()))
                due, twist = self._pacer.next(time.monotonic())
            if due:
                self._override(twist)

    def _override(self, twist: Floats | None) -> None:
        scaling = self._parameters.scaling
        forward_back, left_right = (0, 0) if twist is None else joystick_of(twist, scaling)
        try:
            self._call(
                "JsOverride",
                CALL_TIMEOUT,
                forward_back=forward_back + scaling.centre,
                left_right=left_right + scaling.centre,
                source=protocol.SHARED_REMOTE,
            )
        except grpc.RpcError as error:
            _log.warning("a joystick message is lost: %s", _text(error))
        else:
            self._answered_at = time.monotonic()

    def _select(self, method: str) -> None:
        self._call(method, _RELEASE_TIMEOUT, source=protocol.SHARED_REMOTE)

    def _call(self, method: str, timeout: float, **fields: int) -> Any:
        request = protocol.message(protocol.UNARY[method])
        call = self._channel.unary_unary(
            protocol.path(method),
            request_serializer=request.SerializeToString,
            response_deserializer=protocol.message("Response").FromString,
        )
        return call(request(**fields), timeout=timeout)


def _read(stream: str, call: Any, take: Callable[[Any], None]) -> None:
    try:
        for message in call:
            take(message)
    except grpc.RpcError as error:
        if error.code() is not grpc.StatusCode.CANCELLED:  # then its input gets old
            _log.warning("%s has ended: %s", stream, _text(error))
    except Exception:  # a faulty message must be seen; the input gets old
        _log.exception("%s has ended", stream)


def _text(error: Any) -> str:
    return f"{error.code().name}, {error.details()}"
