"""Cut of the network between `cohelm ros2` and its robot, in a network namespace of its own.

    unshare --net python benchmarks/ros2_network_cut.py [--times 20]      # as root

Loopback goes down for a second while the chair moves. Nothing that cohelm sends can reach the base
then: its own timeout (0.25 s here) stops it. What is measured is the rest: the last command that
moves the base arrives before the cut, and after it nothing moves again until the rider confirms.
"""

from __future__ import annotations

import argparse
import subprocess
import time

from ros2_latency import BASE_TIMEOUT, live_ride

CUT = 1.0  # s
WATCH = 2.0
"""Time after the cut in which nothing may move, s."""


def link(state: str) -> None:
    subprocess.run(["ip", "link", "set", "lo", state], check=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=20)
    times = parser.parse_args().times
    link("up")
    stops, moved, reasons = [], 0, []
    with live_ride() as (rider, commands):
        for _ in range(times):
            rider.confirms = True
            rider.wait(lambda state: state.speed > 0.1 and state.link == "ready")
            time.sleep(0.5)
            rider.confirms = False
            at = time.time()
            link("down")
            time.sleep(CUT)
            link("up")
            time.sleep(WATCH)
            before = [arrival for _, arrival, speed in commands if speed and arrival < at + CUT]
            stops.append(max(before) + BASE_TIMEOUT - at)
            moved += sum(bool(speed) for _, arrival, speed in commands if arrival >= at + CUT)
            reasons.append(rider.state.reason.code if rider.state and rider.state.reason else "")
    print(f"{times} cuts: the base stands {max(stops):.3f} s after the cut at the latest")
    print(f"commands that move it after the cut, without confirmation: {moved}")
    print(f"reasons: {sorted(set(reasons))}")


if __name__ == "__main__":
    main()
