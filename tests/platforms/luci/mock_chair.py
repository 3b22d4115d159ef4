"""Mock of a LUCI chair: a gRPC server with its published interface, and ideal wheels.

It takes the joystick of the input source that was added last, and brakes below 10 messages a
second, as LUCI's documents say.
"""

import threading
import time
from concurrent import futures
from typing import NamedTuple

import grpc
import numpy as np

from cohelm.platforms.luci import protocol

SILENCE = 0.1
"""Time between two messages from which it brakes, s: below 10 Hz."""


class Heard(NamedTuple):
    at: float
    forward_back: int
    left_right: int
    source: int


class MockChair:
    """Server on a free port; a deflection of 100 is 1 m/s, and 1 rad/s to the right."""

    def __init__(self, *, joystick=True, encoders=True, cameras=True, centre=100):
        self.joystick, self.encoders, self.cameras, self.centre = (
            joystick,
            encoders,
            cameras,
            centre,
        )
        self.stick, self.silent, self.frozen = (0, 0), False, threading.Event()
        self.heard, self.sources, self.changes = [], [], []
        self.angles, self.ends = np.array([350.0, 10.0]), False
        self._server = grpc.server(futures.ThreadPoolExecutor(max_workers=16))
        self._server.add_generic_rpc_handlers((self._handlers(),))
        self.port = self._server.add_insecure_port("127.0.0.1:0")
        self._server.start()
        threading.Thread(target=self._roll, daemon=True).start()

    def close(self):
        self.ends = True
        self.frozen.clear()
        self._server.stop(None).wait()

    @property
    def speeds(self):
        """(v, ω) that the wheels follow."""
        fresh = self.heard and time.monotonic() - self.heard[-1].at <= SILENCE
        if not fresh or self.sources != [self.heard[-1].source]:
            return 0.0, 0.0
        last = self.heard[-1]
        return (last.forward_back - self.centre) / 100, -(last.left_right - self.centre) / 100

    def commands(self, since=0.0):
        """Deflections heard since a monotonic time."""
        return [
            (each.forward_back - self.centre, each.left_right - self.centre)
            for each in self.heard
            if each.at >= since
        ]

    def _roll(self):
        while not self.ends:
            v, turn = self.speeds
            sides = np.array([v - turn * 0.28, v + turn * 0.28])  # track 0.56 m
            self.angles = (self.angles + 0.02 * sides * 360.0 / 1.12) % 360.0
            time.sleep(0.02)

    def _handlers(self):
        unary = {
            "JsOverride": self._override,
            "AddInputSource": lambda request, _: self._change("add", request.source),
            "RemoveInputSource": lambda request, _: self._change("remove", request.source),
        }
        streams = {
            "UserJoystickStream": self._joystick,
            "EncoderStream": self._encoders,
            "DecimatedCameraStream": self._cameras,
        }
        handlers = {
            name: grpc.unary_unary_rpc_method_handler(
                call,
                request_deserializer=protocol.message(protocol.UNARY[name]).FromString,
                response_serializer=protocol.message("Response").SerializeToString,
            )
            for name, call in unary.items()
        }
        for name, call in streams.items():
            handlers[name] = grpc.unary_stream_rpc_method_handler(
                call,
                request_deserializer=protocol.Empty.FromString,
                response_serializer=protocol.message(protocol.STREAMS[name]).SerializeToString,
            )
        return grpc.method_handlers_generic_handler(protocol.SERVICE, handlers)

    def _override(self, request, _):
        while self.frozen.is_set():
            time.sleep(0.01)
        self.heard.append(
            Heard(time.monotonic(), request.forward_back, request.left_right, request.source)
        )
        return protocol.message("Response")(reply="ok")

    def _change(self, what, source):
        self.changes.append((time.monotonic(), what, source))
        if what == "add":
            self.sources.append(source)
        else:
            self.sources.remove(source)
        return protocol.message("Response")(reply="ok")

    def _joystick(self, _, context):
        while self.joystick and not self.ends and context.is_active():
            if not self.silent:
                forward, right = self.stick
                yield protocol.message("JoystickData")(forward_back=forward, left_right=right)
            time.sleep(0.05)
        self._wait(context)

    def _encoders(self, _, context):
        while self.encoders and not self.ends and context.is_active():
            left, right = self.angles
            yield protocol.message("EncoderData")(left_angle=left, right_angle=right)
            time.sleep(0.02)
        self._wait(context)

    def _cameras(self, _, context):
        point = protocol.message("Point3D")
        wall = [point(x=3.0, y=0.1 * k, z=0.5) for k in range(-10, 11)]
        while self.cameras and not self.ends and context.is_active():
            yield protocol.message("CameraPoints")(points=wall)
            time.sleep(0.1)
        self._wait(context)

    def _wait(self, context):
        while not self.ends and context.is_active():
            time.sleep(0.05)
