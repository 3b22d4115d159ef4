"""The network between a page and the chair, which a test can cut without anybody being told."""

import contextlib
import select
import socket
import threading

_MOST = 65_536


class Cable:
    """Carries every byte to ``port`` and back, until it is cut; then it swallows them."""

    def __init__(self, port):
        self._to = port
        self._cut = threading.Event()
        self._pairs = {}
        self._over = set()
        self._door = socket.create_server(("127.0.0.1", 0))
        self._door.settimeout(0.2)
        self.port = self._door.getsockname()[1]
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def cut(self):
        """From now on nothing arrives at either end, and nothing is closed."""
        self._cut.set()

    def tear(self):
        """Close what there is, and let nothing new through."""
        self.cut()
        for end in [*self._pairs]:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def mend(self):
        """What was swallowed stays so: connections of before are closed, new ones are carried."""
        self._cut.clear()
        self._over.clear()
        for end in [*self._pairs]:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def close(self):
        self._ends.set()
        self._thread.join()
        for end in (self._door, *self._pairs):
            end.close()

    def _carry(self):
        while not self._ends.is_set():
            heard = [end for end in [*self._pairs] if end not in self._over]
            ready, _, _ = select.select([self._door, *heard], [], [], 0.1)
            for end in ready:
                if end is self._door:
                    self._enter()
                elif end in self._pairs:
                    self._pass_on(end)

    def _enter(self):
        near, _ = self._door.accept()
        far = socket.create_connection(("127.0.0.1", self._to))
        for end in (near, far):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._pairs[near], self._pairs[far] = far, near

    def _pass_on(self, end):
        other = self._pairs[end]
        try:
            data = end.recv(_MOST)
            if data and not self._cut.is_set():
                other.sendall(data)
        except OSError:
            data = b""
        if not data and self._cut.is_set():
            self._over.add(end)  # it would be ready for ever
        elif not data:
            for each in (end, other):
                self._pairs.pop(each, None)
                each.close()
