"""Kill, freeze and cut off each part of a ROS 2 ride, and measure when the base gets a zero.

    python benchmarks/ros2_faults.py [--times 20] [--parts stick,scanner]      # as root

Parts: cohelm, its navigator's process, localiser, scanner, stick, network. Each part has a network
of its own (namespace and virtual cable), so that its cable can be cut. `network` is the cable of
cohelm, over which no zero can arrive: there the base's own timeout of 0.25 s counts. After each
fault the stick stays pushed, the part comes back, and for two seconds nothing may move: the rider
has not let go and confirmed. The navigator has no cable.
"""

from __future__ import annotations

import argparse
import json
import os
import queue
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from ros2_parts import BASE_TIMEOUT

PARTS = ("stick", "scanner", "localiser", "navigator", "cohelm", "network")
AWAY = 1.5  # s, time of the fault
WATCH = 2.0  # s, without motion after it
START = 240.0  # s
NEAR, FAR = 4.0, 12.0
"""x between which the chair goes to and fro, m."""
BRIDGE = "cohelm-bridge"


class Part:
    """Process of a part, with its cable.

    Args:
        name: See ``ros2_parts``.
        number: Number of its address.
    """

    def __init__(self, name: str, number: int) -> None:
        self.name, self._number, self._cable = name, number, f"cable{number}"
        self.lines: queue.SimpleQueue[tuple[Any, ...]] = queue.SimpleQueue()
        self.start()

    def start(self) -> None:
        """Start the process, and plug it in."""
        script = Path(__file__).with_name("ros2_parts.py")
        wait = "until ip -4 addr show inside 2> /dev/null | grep -q inet; do sleep 0.02; done"
        run = f"{wait}; exec {sys.executable} {script} {self.name}"
        self.process = subprocess.Popen(
            ["unshare", "--net", "sh", "-c", run],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, "COHELM_INTERFACE": "inside"},
        )  # fmt: skip
        pid = self.process.pid
        while Path(f"/proc/{pid}/ns/net").readlink() == Path("/proc/self/ns/net").readlink():
            time.sleep(0.01)
        # The end of the last one's cable vanishes with its namespace, which takes a moment.
        while subprocess.run(
            ["ip", "link", "add", self._cable, "type", "veth", "peer", "name", "inside",
             "netns", str(pid)], check=False, stderr=subprocess.DEVNULL,
        ).returncode:  # fmt: skip
            time.sleep(0.05)
        ip("link", "set", self._cable, "master", BRIDGE, "up")
        inside = ("nsenter", "-t", str(pid), "-n")
        ip("link", "set", "lo", "up", before=inside)
        ip("link", "set", "inside", "up", before=inside)
        ip("addr", "add", f"10.9.0.{self._number}/24", "dev", "inside", before=inside)
        threading.Thread(target=self._read, args=(self.process,), daemon=True).start()

    def plug(self, state: str) -> None:
        """Set the cable ``up`` or ``down``."""
        ip("link", "set", self._cable, state)

    def say(self, **values: Any) -> None:
        """Write a line to its stdin."""
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(values) + "\n")
        self.process.stdin.flush()

    def _read(self, process: subprocess.Popen[str]) -> None:
        for line in process.stdout or ():
            if line.startswith("["):
                self.lines.put(tuple(json.loads(line)))


def ip(*arguments: str, before: tuple[str, ...] = ()) -> None:
    subprocess.run([*before, "ip", *arguments], check=True)


class Ride:
    """A ride with all parts."""

    def __init__(self) -> None:
        names = ("base", "scanner", "localiser", "stick", "cohelm")
        self.parts = {name: Part(name, k + 1) for k, name in enumerate(names)}
        self.commands: list[tuple[float, bool]] = []
        self.link, self.reason, self.navigator, self.x = "", "", 0, 0.0
        self.direction, self.dropped = 1.0, 0

    def look(self) -> None:
        """Take what the parts have said."""
        base, cohelm = self.parts["base"].lines, self.parts["cohelm"].lines
        while not base.empty():
            kind, *values = base.get()
            if kind == "command":
                self.commands.append((values[0], values[1]))
            elif kind == "dropped":
                self.dropped += 1
            else:
                self.x = values[0]
        while not cohelm.empty():
            _, self.link, self.reason, self.navigator = cohelm.get()

    def wait(self, seconds: float) -> None:
        """Look for a time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.look()
            time.sleep(0.005)

    def drive(self) -> None:
        """Let go, confirm and push, until the chair moves."""
        stick, end = self.parts["stick"], time.monotonic() + START
        while time.monotonic() < end:
            stick.say(forward=0.0, left=0.0, confirm=False)
            self.wait(0.3)
            if self.link == "confirm":
                stick.say(confirm=True)
                self.wait(0.3)
                stick.say(confirm=False)
            if self.link != "ready":
                continue
            if not NEAR < self.x < FAR:
                self.direction = 1.0 if self.x <= NEAR else -1.0
            stick.say(forward=0.6 * self.direction)
            self.wait(1.5)
            newest = [moves for at, moves in self.commands if at > time.monotonic() - 0.5]
            if len(newest) > 5 and all(newest):
                return
            stick.say(forward=0.0, left=0.8)  # something is in the way: look elsewhere
            self.wait(2.0)
        sys.exit(f"the chair does not drive: {self.link}, {self.reason}")

    def fault(self, part: str, how: str) -> tuple[float, bool, str]:
        """Break a part and mend it; returns the time to the zero, s, motion after it, and why."""
        pid = self.navigator if part == "navigator" else 0
        pid = pid or self.parts["cohelm" if part == "network" else part].process.pid
        process = self.parts.get("cohelm" if part == "network" else part)
        at = time.monotonic()
        if how == "cut" and process is not None:
            process.plug("down")
        else:
            os.kill(pid, signal.SIGKILL if how == "kill" else signal.SIGSTOP)
        self.wait(AWAY)
        reason = self.reason
        if how == "cut" and process is not None:
            process.plug("up")
        elif how == "freeze":
            os.kill(pid, signal.SIGCONT)
        elif process is not None:
            process.process.wait()
            process.start()
            if part == "stick":
                process.say(forward=0.6 * self.direction)
            if part == "cohelm":
                self.link = ""
                while self.link != "centre_stick":
                    self.wait(0.1)
        self.wait(WATCH)
        return (*self.judged(at, cut=part == "network"), reason)

    def judged(self, begun: float, *, cut: bool) -> tuple[float, bool]:
        """Return the time until the base stands for good, s, and whether it moved after that.

        Motion before the part comes back counts as late, motion after it as motion without
        confirmation.
        """
        back = begun + AWAY
        last = max((t for t, moves in self.commands if moves and t < back), default=begun)
        zeros = [t for t, moves in self.commands if not moves and t > max(last, begun)]
        stands = last + BASE_TIMEOUT if cut else zeros[0] if zeros else np.inf
        again = [t - back for t, moves in self.commands if moves and t >= back]
        if again:
            print(f"  moved {again[0]:.3f} to {again[-1]:.3f} s after the part was back, "
                  f"{len(again)} commands; {self.link}, {self.reason}", flush=True)  # fmt: skip
        return stands - begun, bool(again)


def measure(ride: Ride, part: str, how: str, times: int) -> bool:
    """Break a part again and again and print the figures; returns True if all is well."""
    delays, again, reasons, dropped = [], 0, set(), ride.dropped
    for k in range(times):
        ride.drive()
        ride.wait(0.0137 * k)
        delay, moved, reason = ride.fault(part, how)
        delays.append(delay)
        again += moved
        reasons.add(reason)
    worst, median = max(delays), float(np.median(delays))
    print(f"{part:10} {how:7} {times:3} times: zero after {median:.3f} s, worst {worst:.3f} s; "
          f"moved again {again}; dropped by the base as old {ride.dropped - dropped}; "
          f"load {os.getloadavg()[0]:.1f}; {', '.join(sorted(reasons))}", flush=True)  # fmt: skip
    return worst <= 0.35 and not again


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--ways", default="kill,freeze,cut")
    given = parser.parse_args()
    if "COHELM_INSIDE" not in os.environ:  # again, in a network of its own
        if os.geteuid() or not shutil.which("ip"):
            sys.exit("needs root and the command 'ip' (Debian: iproute2)")
        os.environ["COHELM_INSIDE"] = "1"
        os.execvp("unshare", ["unshare", "--net", sys.executable, *sys.argv])
    ip("link", "add", BRIDGE, "type", "bridge")
    ip("link", "set", BRIDGE, "up")
    ride, well = Ride(), True
    try:
        for part in given.parts.split(","):
            for how in given.ways.split(","):
                if (part, how) in {("navigator", "cut"), ("cohelm", "cut")} or (
                    part == "network" and how != "cut"
                ):
                    continue
                well &= measure(ride, part, how, given.times)
    finally:
        for each in ride.parts.values():
            each.process.kill()
    sys.exit(0 if well else 1)


if __name__ == "__main__":
    main()
