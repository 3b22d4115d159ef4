"""Latency of `cohelm ros2`, from a scan on its topic to the command on its topic.

    python benchmarks/ros2_latency.py [--seconds 60] [--cloud]

A simulated robot in a process of its own sends scan, odometry and transforms over DDS on loopback;
`--cloud` adds a PointCloud2 of 64 kB ten times a second. The whole live ride runs: control loop,
navigator's process, the process of the command topic. Each scan belongs to the first control step
that observes it, and the step to the command with its stamp, as it arrives at the robot. The second
row leaves out the time from the scan to its step.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from cohelm.live import Drive, DriveSetup
from cohelm.live.messages import (
    ChairState,
    Heartbeat,
    ResumeCommand,
    SetGoal,
    SetMode,
    TakeControl,
    ToPage,
)
from cohelm.messages import Decision, Mode, Observation
from cohelm.ros2.platform import RobotNode, Ros2, Ros2Platform
from cohelm.scenarios import RideSetup, Scenario, load_scenario

ROBOT = Path(__file__).parents[1] / "examples" / "ros2_robot.py"
SCENARIO, PEOPLE, SEED = "hospital", 10, 1
START = 100.0  # s
STEPS: list[tuple[float, float, list[float], float]] = []
"""(begin, stamp of the command, stamps of the observed scans, processor time of the control thread
from begin to command) of each control step, s."""
TICKS_PER_SECOND = os.sysconf("SC_CLK_TCK")


def scenario() -> Scenario:
    given = load_scenario(SCENARIO)
    return given.model_copy(update={"people": given.people.model_copy(update={"count": PEOPLE})})


class TimedPlatform(Ros2Platform):
    """Robot that notes its control steps."""

    def observe(self) -> Observation:
        """Note the scans of the step."""
        began, seen = time.time(), super().observe()
        stamp = self.node.clock.stamp
        self._step = began, [stamp(each.time) for each in seen.scans], time.thread_time()
        return seen

    def apply(self, decision: Decision) -> None:
        """Note the time of the command."""
        began, scans, spent = self._step
        STEPS.append((began, time.time(), scans, time.thread_time() - spent))
        super().apply(decision)


class TimedRos2(Ros2):
    """Plugin of :class:`TimedPlatform`."""

    def open(self, setup: RideSetup) -> TimedPlatform:
        """Wait for the robot."""
        node = RobotNode(self.parameters)
        node.wait()
        return TimedPlatform(node)


class Rider(threading.Thread):
    """Page of a rider who is always there, and confirms while ``confirms`` is set."""

    def __init__(self, drive: Drive, goal: str) -> None:
        super().__init__(daemon=True)
        self.drive, self.goal, self.confirms, self.ends = drive, goal, True, False
        self.state: ChairState | None = None
        drive.listen(self._take)
        drive.connect("page", "driver")
        drive.receive("page", TakeControl())
        drive.receive("page", SetMode(mode=Mode.AUTONOMOUS))

    def run(self) -> None:
        """Beat, confirm and choose the destination."""
        seq = 0
        while not self.ends:
            seq, now, state = seq + 1, time.monotonic(), self.state
            self.drive.receive("page", Heartbeat(seq=seq, sent=1000.0 * now), now)
            if self.drive.health.ready and state is not None:
                if state.link == "confirm" and self.confirms:
                    self.drive.receive("page", ResumeCommand())
                if state.goal is None:
                    self.drive.receive("page", SetGoal(place=self.goal))
            time.sleep(0.1)

    def wait(self, holds: Callable[[ChairState], bool]) -> None:
        """Wait until a state has a property."""
        end = time.monotonic() + START
        while self.state is None or not holds(self.state):
            if time.monotonic() > end:
                sys.exit(f"waited for {START:g} s: {self.state and self.state.reason}")
            time.sleep(0.02)

    def _take(self, message: ToPage, _: str | None) -> None:
        if isinstance(message, ChairState):
            self.state = message


Commands = list[tuple[float, float, float]]


@contextlib.contextmanager
def live_ride(*, cloud: bool = False) -> Iterator[tuple[Rider, Commands]]:
    """A ride with its rider, and (stamp, arrival, speed) of the commands at the robot so far."""
    sys.modules["ros2_latency"] = sys.modules[__name__]
    options = [SCENARIO, "--people", str(PEOPLE), "--seed", str(SEED), *["--cloud"] * cloud]
    command = [sys.executable, str(ROBOT), *options]
    commands: Commands = []
    platform = {"use": "ros2_latency:TimedRos2", "dds": {"interface": "lo"}, "wait": START}
    clouds = ("/points",) if cloud else ()
    given = scenario().model_copy(update={"platform": {**platform, "clouds": clouds}})
    with (
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as robot,
    ):
        lines = (commands.append(tuple(json.loads(line))) for line in robot.stdout or ())
        threading.Thread(target=lambda: list(lines), daemon=True).start()
        drive = Drive(DriveSetup(scenario=given, folder=Path(folder)))
        drive.start()
        rider = Rider(drive, str(given.goal))
        rider.start()
        try:
            yield rider, commands
        finally:
            rider.ends = True
            rider.join()
            drive.close()
            robot.kill()


def processor_time(pid: int | None) -> float:
    """Processor time of a process so far, s."""
    fields = Path(f"/proc/{pid or 'self'}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_SECOND


def report(commands: Commands) -> None:
    """Print latency and jitter, ms."""
    stamps = np.array([stamp for stamp, _, _ in commands])
    total, computing, arrivals = [], [], []
    for began, sent, scans, _ in STEPS:
        k = int(np.argmin(np.abs(stamps - sent)))
        if abs(stamps[k] - sent) > 0.005:
            continue  # published by nobody: a stop in between
        arrivals.append(commands[k][1])
        total += [1e3 * (commands[k][1] - each) for each in scans]
        computing += [1e3 * (commands[k][1] - began)] if scans else []
    for name, values in (("scan to command", total), ("step to command", computing)):
        print(f"{name}: median {np.median(values):.1f}, p99 {np.percentile(values, 99):.1f}, "
              f"max {max(values):.1f} ms, n {len(values)}")  # fmt: skip
    gaps = 1e3 * np.diff(arrivals)
    print(f"command period: median {np.median(gaps):.1f}, standard deviation {gaps.std():.1f}, "
          f"p99 {np.percentile(gaps, 99):.1f} ms")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--cloud", action="store_true")
    given = parser.parse_args()
    load = os.getloadavg()[0]
    with live_ride(cloud=given.cloud) as (rider, commands):
        rider.wait(lambda state: state.speed > 0.1)
        STEPS.clear()
        pids = {"this process": None, "navigator": rider.drive.navigator_pid}
        before = {name: processor_time(pid) for name, pid in pids.items()}
        time.sleep(given.seconds)
        health, steps = rider.drive.health, len(STEPS)
        spent = {name: processor_time(pid) - before[name] for name, pid in pids.items()}
    print(f"{PEOPLE} people, cloud {given.cloud}, load {load:.1f} to {os.getloadavg()[0]:.1f}")
    # On a quiet core a step takes about its processor time, whatever the load was here.
    own = [1e3 * cpu for *_, cpu in STEPS]
    print(f"processor time of the control thread from observation to command: "
          f"median {np.median(own):.1f}, p99 {np.percentile(own, 99):.1f} ms")  # fmt: skip
    each = ", ".join(f"{name} {1e3 * value / steps:.1f} ms" for name, value in spent.items())
    print(f"processor time a step, all threads: {each}")
    print(f"deadlines missed: {health.missed} of {health.ticks}")
    report(commands)


if __name__ == "__main__":
    main()
