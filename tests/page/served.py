"""``cohelm drive`` as anybody starts it, and a second page's socket that sees what it does."""

import contextlib
import itertools
import json
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections import deque
from pathlib import Path

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from cohelm.live.sessions.database import Database
from cohelm.live.sessions.response import reset_response

_READY = 300.0
_STEP = 0.05


class Chair:
    """A process of ``cohelm drive``, watched through its own messages.

    state: the newest.  states: those of the last minutes.  told: everything else, in its order.
    """

    def __init__(self, folder, *options, command="drive"):
        command = [sys.executable, "-m", "cohelm", command, *options, "--port", "0"]
        self.log, self.data = folder / "log.txt", folder / "data"
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                [*command, "--data", str(self.data)], stdout=subprocess.PIPE, stderr=log,
                text=True,
            )  # fmt: skip
        said = self._printed("Ctrl-C")
        self.address = re.search(r"drive +(http://\S+?)/?$", said, re.MULTILINE)[1]
        self.token = re.search(r"therapist#token=(\S+)", said)[1]
        self.port = int(self.address.rsplit(":", 1)[1])
        self.states, self.told = deque(maxlen=6000), deque(maxlen=2000)
        self.state, self.scene = {}, {}
        self._asked = 0
        self._socket = None
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _printed(self, last):
        """All lines up to the one with ``last``; an error if the process ends before."""
        lines = []
        for line in self.process.stdout:
            lines.append(line)
            if last in line:
                return "".join(lines)
        raise AssertionError("".join(lines) + self.log.read_text())

    def __enter__(self):
        try:
            self.until(lambda state: state["reason"]["code"] == "no_driver", within=_READY)
            limit = time.monotonic() + _READY
            while not self.health()["ready"]:
                assert time.monotonic() < limit, self.log.read_text()
                time.sleep(0.5)
            self._first = self._processes()[0]
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self._socket is not None:
            self._socket.close()
        self._thread.join(10.0)
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(20.0)
        finally:
            self.process.kill()
            self.process.stdout.close()

    def health(self):
        with urllib.request.urlopen(f"{self.address}/api/health", timeout=10.0) as answer:
            return json.load(answer)

    def say(self, kind, **more):
        """Ask as a page does that does not drive; returns the answer."""
        self._asked += 1
        assert self._socket is not None
        self._socket.send(json.dumps({"type": kind, "id": self._asked, **more}))
        return self.heard(lambda told: told.get("id") == self._asked)

    def heard(self, law, within=20.0):
        """The first of what was told, states apart, that fulfils a law."""
        limit = time.monotonic() + within
        while time.monotonic() < limit:
            for each in [*self.told]:
                if law(each):
                    return each
            time.sleep(0.01)
        raise AssertionError(f"was not told; the last was {list(self.told)[-3:]}")

    def until(self, law, within=20.0, rest=time.sleep):
        """The first state, from the present one on, that fulfils a law."""
        limit = time.monotonic() + within
        since = self.state.get("clock", 0.0)
        while True:
            for state in [each for each in [*self.states] if each["clock"] >= since]:
                if law(state):
                    return state
                since = state["clock"]
            assert time.monotonic() < limit, f"still {brief(self.state)}"
            rest(0.02)

    def restart(self):
        """The same world from its beginning: nobody at the stick, nothing asked for or learned."""
        reset_response(Database(self.data))
        self.until(lambda state: state["driver"] is None)
        self.told.clear()
        self.say("change_simulation", action="restart", seed=0)
        self.heard(lambda told: told.get("code") == "simulation_restarted")
        self.say("set_mode", mode="shared")
        self.say("set_pace", pace="normal")
        self.states.clear()
        self.until(lambda state: not state["paused"] and state["reason"]["code"] == "no_driver")

    @property
    def untouched(self):
        """Whether nothing has happened since it began."""
        states, told = [*self.states], [*self.told]
        return not (
            any(map(_touched, states))
            or len({len(each["true_people"]) for each in states}) > 1
            or any(each["type"] == "route" and each["wishes"] for each in told)
            or any(each.get("code") == "simulation_restarted" for each in told)
        )

    def stood(self, since):
        """When the wheels first stood after ``since``, of ``time.monotonic``, by the chair's own
        clock: both are of this machine."""
        states = [*self.states]
        assert not all(held(each) for each in states if since - 0.3 < each["clock"] < since)
        return next(each["clock"] for each in states if each["clock"] >= since and held(each))

    def lateness(self, since):
        """By how much the machine kept the chair from its work after ``since``, s."""
        found = [each for each in [*self.states] if each["clock"] >= since - _STEP]
        gaps = [b["clock"] - a["clock"] - _STEP for a, b in itertools.pairwise(found)]
        return max([*gaps, *(each["lateness"] / 1000.0 for each in found)], default=0.0)

    @property
    def navigator(self):
        """Its pid: the first process that was begun or, where that one is gone, the busiest."""
        found = self._processes()
        if self._first in found:
            return self._first
        before = {pid: _spent(pid) for pid in found}
        time.sleep(1.0)
        return max(found, key=lambda pid: _spent(pid) - before[pid])

    @property
    def previews(self):
        """Pid of the process that plans the routes to choose from."""
        return next(pid for pid in self._processes() if pid != self.navigator)

    def _processes(self):
        """Pids of those that the server began, in their order."""
        children = []
        for each in Path(f"/proc/{self.process.pid}/task").iterdir():
            with contextlib.suppress(OSError):
                children += map(int, (each / "children").read_text().split())
        spawned = [pid for pid in children if b"spawn_main" in _read(pid, "cmdline")]
        return sorted(spawned, key=lambda pid: _numbers(pid)[18])

    def _watch(self):
        where = f"ws://127.0.0.1:{self.port}/ws"
        page = connect(where, origin=self.address, compression=None)
        with page as self._socket, contextlib.suppress(ConnectionClosed):
            while True:
                self._heed(json.loads(self._socket.recv()))

    def _heed(self, message):
        if message["type"] == "state":
            self.states.append(message)
            self.state = message
            return
        if message["type"] == "welcome":
            self.scene = message["scene"]
        self.told.append(message)


def held(state):
    """The wheels are told to stand."""
    return state["command"] == [0.0, 0.0]


def stands(state):
    """They do; what the chair says of its speed is measured, with odometry's noise in it."""
    return held(state) and abs(state["speed"]) < 0.05 and abs(state["turn_rate"]) < 0.1


def moves(state):
    return abs(state["speed"]) > 0.1 or abs(state["turn_rate"]) > 0.1


def wants(state):
    """The wheels are told to turn."""
    return abs(state["command"][0]) > 0.05 or abs(state["command"][1]) > 0.1


def _touched(state):
    asked = state["goal"] or state["driver"] or state["paused"] or state["closed_doors"]
    return bool(any(state["command"]) or asked)


def brief(state):
    shown = (
        "time",
        "driver",
        "link",
        "mode",
        "speed",
        "turn_rate",
        "command",
        "goal",
        "reason",
        "lateness",
    )
    return {key: state.get(key) for key in shown}


def _read(pid, what):
    try:
        return Path(f"/proc/{pid}/{what}").read_bytes()
    except OSError:
        return b""


def _numbers(pid):
    """Of a process that is there, by proc(5), from its parent on."""
    return [*map(int, _read(pid, "stat").rsplit(b")", 1)[1].split()[1:])]


def _spent(pid):
    """User and system time, in the kernel's ticks; 0 of a process that has ended meanwhile."""
    return sum(_numbers(pid)[10:12]) if _read(pid, "stat") else 0
