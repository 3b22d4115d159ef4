"""Delay from the stick to the wheels of ``cohelm drive``, and stability of a long drive.

    python benchmarks/drive.py                # a minute: input to wheels
    python benchmarks/drive.py --minutes 10   # a long drive: memory, deadlines, the program's log

A scripted rider connects to the socket of ``cohelm drive``, rides from place to place and nudges
the stick. The delay of a nudge ends when a state message shows that the wheels follow it, so it
includes the transmission of that message. Memory is that of the program and its processes, read
from ``/proc``.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

BEAT = 0.1
"""Interval of heartbeats, s."""
PUSH = 0.35
"""Interval of changes of the stick, s; no multiple of a step, so that all phases of it occur."""
OFTEN, WHILE = 15.0, 4.0
"""Period and duration of the nudges, s; in between the chair follows its path, because a chair that
is nudged all the time would not arrive."""
PLACES = ("Ward 4", "Cafeteria", "Laboratory", "Reception", "Therapy", "Pharmacy")
LONG = 90.0
"""Time after which the next place is chosen, even if the last one was not reached, s."""
LOOK = 10.0
"""Interval of the samples of memory and health, s."""


class Rider:
    """Client without a screen: heartbeats, nudges, destinations, and their results."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.client = ""
        self.state: dict[str, Any] = {}
        self.seq = 0
        self.stick = 0.0
        self.pushed: dict[int, float] = {}
        self.took: list[float] = []
        self.arrived = 0
        self.confirmed = 0

    async def send(self, **message: object) -> None:
        """Send one message."""
        await self.socket.send(json.dumps(message))

    async def beat(self) -> None:
        """Send heartbeat and stick position."""
        self.seq += 1
        await self.send(
            type="heartbeat",
            seq=self.seq,
            sent=1e3 * time.monotonic(),
            forward=self.stick,
            device="keys" if self.stick else "none",
        )

    async def listen(self) -> None:
        """Receive the messages of the chair."""
        async for text in self.socket:
            now, said = time.monotonic(), json.loads(text)
            if said["type"] == "welcome":
                self.client = said["client"]
            elif said["type"] == "ride_ended":
                self.arrived += said["outcome"] == "arrived"
            elif said["type"] == "state":
                self.state = said
                if said["driver"] == self.client:
                    for seq in [each for each in self.pushed if each <= said["heartbeat"]]:
                        self.took.append(1e3 * (now - self.pushed.pop(seq)))

    async def drive(self, seconds: float) -> None:
        """Ride from place to place, nudge the stick, and confirm each request for confirmation."""
        await self.send(type="take_control")
        end, chosen, push, k = time.monotonic() + seconds, 0.0, 0.0, 0
        while (now := time.monotonic()) < end:
            await asyncio.sleep(BEAT / 4)
            link, changed = self.state.get("link"), False
            if link == "confirm" and not self.stick:
                self.confirmed += 1
                await self.send(type="resume")
            if link == "ready" and (self.state["goal"] is None or now - chosen > LONG):
                await self.send(type="set_goal", id=k + 1, place=PLACES[k % len(PLACES)])
                chosen, k = now, k + 1
            pushes = now % OFTEN < WHILE
            if link == "ready" and now - push > PUSH and (pushes or self.stick):
                self.stick, push, changed = 0.3 - self.stick, now, True
            elif link in {"centre_stick", "stick_held", "confirm", "no_heartbeat"}:
                self.stick = 0.0
            if changed or now * 40 % 4 < 1:
                await self.beat()
            if changed:
                self.pushed[self.seq] = time.monotonic()


def main() -> int:
    """Drive and print the figures; 1 if memory grew or a streak of deadlines was missed."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--minutes", type=float, default=1.0)
    options.add_argument("--people", type=int, default=12)
    chosen = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        with log.open("w") as file:
            program = subprocess.Popen(  # own program, fixed arguments
                [
                    *(sys.executable, "-m", "cohelm", "drive", "hospital", "--port", "0"),
                    *("--people", str(chosen.people), "--data", folder),
                ],
                stdout=subprocess.PIPE,
                stderr=file,
                text=True,
                start_new_session=True,
            )
            try:
                found = asyncio.run(ridden(program, 60.0 * chosen.minutes))
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(program.pid, signal.SIGINT)
                program.wait(60)
        return told(found, log.read_text())


async def ridden(program: subprocess.Popen[str], seconds: float) -> dict[str, Any]:
    """Drive for a time, and sample memory and health of the program."""
    address = ""
    while "Ctrl-C" not in (line := program.stdout.readline() if program.stdout else "Ctrl-C"):
        address = line.split()[-1].rstrip("/") if " drive " in f" {line} " else address
    while not health(address)["ready"]:
        await asyncio.sleep(1.0)
    looks: list[tuple[float, float]] = []
    async with connect(f"ws{address[4:]}/ws", origin=address) as socket:
        rider = Rider(socket)
        hears = asyncio.create_task(rider.listen())
        before = health(address)
        drives = asyncio.create_task(rider.drive(seconds))
        began = time.monotonic()
        while not drives.done():
            looks.append((time.monotonic() - began, memory(program.pid)))
            await asyncio.wait([drives], timeout=LOOK)
        await drives
        after = health(address)
        hears.cancel()
    return {"rider": rider, "looks": looks, "before": before, "after": after}


def health(address: str) -> dict[str, Any]:
    """Health report of the program."""
    with urllib.request.urlopen(f"{address}/api/health", timeout=5) as answer:  # ours
        found: dict[str, Any] = json.load(answer)
        return found


def memory(root: int) -> float:
    """Memory of a process and its descendants, MB; shared pages in proportion."""
    parents: dict[int, int] = {}
    for each in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            parents[int(each.parent.name)] = int(each.read_text().rsplit(")", 1)[1].split()[1])
    family, grown = {root}, True
    while grown:
        more = {child for child, parent in parents.items() if parent in family} - family
        family, grown = family | more, bool(more)
    held = 0.0
    for one in family:
        with suppress(OSError):
            rows = Path(f"/proc/{one}/smaps_rollup").read_text().splitlines()
            held += sum(float(row.split()[1]) for row in rows if row.startswith("Pss:")) / 1024
    return held


def told(found: dict[str, Any], log: str) -> int:
    """Print the figures; 1 if a requirement fails."""
    rider, after = found["rider"], found["after"]
    took = np.array(rider.took)
    print(
        f"input to wheels over {len(took)} pushes: median {np.median(took):.0f} ms,"
        f" p99 {np.percentile(took, 99):.0f} ms, maximum {took.max():.0f} ms"
    )
    ticks, missed = (after[key] - found["before"][key] for key in ("ticks", "missed"))
    print(f"{ticks} ticks, {missed} late, longest streak {after['longest_streak']}")
    print(f"{rider.arrived} arrivals, confirmed {rider.confirmed} times,", end=" ")
    print(f"watchdog {after['stops']} times, navigators restarted {after['restarts']}")
    time_, held = np.array(found["looks"]).T
    settled = time_ > min(120.0, time_[-1] / 3)
    slope = 60.0 * np.polyfit(time_[settled], held[settled], 1)[0] if settled.sum() > 2 else np.nan
    print(f"memory {held[settled][0]:.0f} to {held[-1]:.0f} MB, {slope:+.2f} MB a minute")
    lines = [line for line in log.splitlines() if line.strip()]
    print(f"the program's log: {len(lines)} lines")
    print("\n".join(lines[:20]))
    return int(after["longest_streak"] > 3)


if __name__ == "__main__":
    sys.exit(main())
