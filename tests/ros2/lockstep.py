"""Rides through ROS 2 topics in step with a simulated robot in another process.

python -m tests.ros2.lockstep SCENARIO SEED…      prints both rides, here and through topics
"""

import contextlib
import json
import os
import subprocess
import sys
import time
from dataclasses import replace

from cohelm.evaluation import Outcome, run
from cohelm.navigation import Navigator
from cohelm.ros2.command_process import WheelCommand
from cohelm.ros2.platform import RobotNode
from cohelm.scenarios import build_scenario, load_scenario
from tests.ros2.loopback import LOOPBACK

EPOCH = 100.0
START = 120.0
"""Maximum time for the robot's process to start, s."""
LOST = 2.0
"""Time after which a message counts as lost, s."""


@contextlib.contextmanager
def robot(scenario, seed, *faults):
    """The robot's process; it ends with the context."""
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-m", "tests.ros2.robot_node", scenario, str(seed), *faults]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def ride(scenario, seed):
    """Return (outcome, time, lost messages, ticks) of a ride through topics."""
    setup = build_scenario(load_scenario(scenario), seed)
    parameters = LOOPBACK.model_copy(update={"use_sim_time": True})
    navigator, tick, lost, stood = Navigator(setup.navigator), None, 0, 0.0
    newest = -1.0
    with robot(scenario, seed, "lockstep=1") as process:
        node = RobotNode(parameters)
        try:
            for line in process.stdout:
                row = json.loads(line)
                if row["hit"]:
                    return Outcome.COLLISION, row["time"], lost, row["steps"]
                if row["arrived"] is not None:
                    return Outcome.REACHED, row["arrived"], lost, row["steps"]
                stood = 0.0 if abs(row["speed"]) > 0.02 else stood + 0.05
                if (
                    row["time"] >= setup.scenario.time_limit
                    or stood > setup.scenario.standing_limit
                ):
                    return Outcome.STOPPED, row["time"], lost, row["steps"]
                first = tick is None
                if first:
                    node.wait()
                lost += not complete(node, row, START if first else LOST)
                seen = node.inputs.observation()
                # The first step is sent repeatedly, until somebody listens.
                new = tuple(each for each in seen.scans if each.time > newest)
                newest = max([newest, *(each.time for each in new)])
                seen = replace(seen, scans=new[-1:])
                tick = navigator.step(seen, setup.request, tick)
                twist = tuple(float(each) for each in tick.decision.twist)
                node.stop(WheelCommand(0.0, EPOCH + row["time"], twist))
        finally:
            node.close()
    raise AssertionError("the robot's process has ended")


def complete(node, row, timeout):
    """Wait until everything of a step has arrived; False if something is lost."""
    end, inputs, time_ = time.monotonic() + timeout, node.inputs, row["time"] - 1e-3
    while time.monotonic() < end:
        scan = inputs.last_scan.get("/scan")
        scanned = row["scan"] is None or (scan is not None and scan.time > row["scan"] - 1e-3)
        if scanned and node.clock.now() > time_ and inputs.odometry_time > time_:
            return True
        time.sleep(0.001)
    return False


def main():
    """Print each ride through topics beside the one in process."""
    for seed in map(int, sys.argv[2:]):
        here = run(load_scenario(sys.argv[1]), seed)
        began = time.monotonic()
        outcome, end, lost, ticks = ride(sys.argv[1], seed)
        spent = time.monotonic() - began
        print(  # noqa: T201  # the answer of this program
            f"{sys.argv[1]} {seed}: in process {here.outcome.value} {here.time[-1]:.2f} s, "
            f"topics {outcome.value} {end:.2f} s, {lost} of {ticks} steps lost messages, "
            f"{1e3 * spent / ticks:.0f} ms a step",
            flush=True,
        )


if __name__ == "__main__":
    main()
