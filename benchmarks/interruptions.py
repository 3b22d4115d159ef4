"""Kill and freeze the processes of a live ride again and again, and measure when the chair stands.

    python benchmarks/interruptions.py --times 50
    python benchmarks/interruptions.py --times 50 --part previews

The chair is driven by its stick. In turn the navigator is killed, the navigator frozen, the
previews' process killed, and frozen. For the navigator the time to the first command of zero at the
wheels is measured, by the clock of the chair; then it must drive again, after at most one
confirmation where the process was replaced. The previews must not stop the chair, and answer again.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cohelm.live import Drive, DriveSetup
from cohelm.live.messages import (
    ChairState,
    Heartbeat,
    PlanTrip,
    ResumeCommand,
    RouteWish,
    SetGoal,
    SetMode,
    TakeControl,
    ToPage,
)
from cohelm.messages import Mode
from cohelm.scenarios import load_scenario

PATIENCE = 120.0
"""Maximum time to get ready again, s."""
FROZEN = 1.0
"""Time for which a process is suspended, s."""
AWAY = 3.5
"""Distance from the start at which the chair turns back, m."""


class Rider:
    """Page without a screen: heartbeats, and a stick that goes forward and back."""

    def __init__(self, drive: Drive) -> None:
        self.drive, self.stick = drive, 0.0
        self.states: list[ChairState] = []
        self.messages: list[Any] = []
        self._seq, self._ends = 0, threading.Event()
        drive.listen(self._hear)
        drive.connect("rider", "driver")
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def _hear(self, message: ToPage, client: str | None) -> None:
        (self.states if isinstance(message, ChairState) else self.messages).append(message)

    def _beat(self) -> None:
        while not self._ends.wait(0.05):
            self._seq += 1
            beat = Heartbeat(
                seq=self._seq,
                sent=1e3 * time.monotonic(),
                forward=self.stick,
                device="keys" if self.stick else "none",
            )
            self.say(beat)

    def say(self, message: Any) -> None:
        """Send a message."""
        self.drive.receive("rider", message, time.monotonic())

    def until(self, holds: Callable[[ChairState], bool], since: int = -1) -> ChairState:
        """Wait for a state in which something holds, from state number ``since`` on."""
        at = len(self.states) if since < 0 else since
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for state in self.states[at:]:
                at += 1
                if holds(state):
                    return state
            time.sleep(0.005)
        raise TimeoutError(f"it never came; now {self.states[-1]}")

    def moves(self) -> int:
        """Drive; returns the number of confirmations that were needed."""
        confirmed, end = 0, time.monotonic() + PATIENCE
        while time.monotonic() < end:
            state = self.states[-1]
            # A chair that still rolls with a released stick would stand by itself.
            if self.stick and abs(state.speed) > 0.15 and state.link == "ready":
                return confirmed
            if state.link == "ready":
                self.stick = 0.6 if state.pose[0] < AWAY else -0.6
                time.sleep(0.1)
                continue
            self.stick = 0.0
            if state.link == "confirm":
                self.say(ResumeCommand())
                confirmed += 1
            time.sleep(0.3)
        raise TimeoutError(f"it does not drive; now {self.states[-1]}")

    def close(self) -> None:
        """Stop the heartbeats."""
        self._ends.set()
        self._thread.join()


def stands(state: ChairState) -> bool:
    """Check that the command at the wheels is zero."""
    return state.command == (0.0, 0.0)


def interrupt_navigator(rider: Rider, how: str) -> tuple[float, int]:
    """Return the time to zero at the wheels, s, and the number of confirmations afterwards."""
    rider.moves()
    pid, since, number = rider.drive.navigator_pid, time.monotonic(), len(rider.states)
    assert pid is not None
    os.kill(pid, signal.SIGKILL if how == "killed" else signal.SIGSTOP)
    state = rider.until(stands, number)
    took = state.clock - since
    if how == "frozen":
        time.sleep(FROZEN)
        _wake(pid)
    else:
        until = time.monotonic() + PATIENCE
        while not rider.drive.health.ready and time.monotonic() < until:
            time.sleep(0.05)
    return took, rider.moves()


def interrupt_previews(rider: Rider, how: str) -> tuple[int, float]:
    """Return the stops of the chair that the navigator did not cause, and the time to an answer."""
    rider.moves()
    process = previews()
    number = len(rider.states)
    os.kill(process, signal.SIGKILL if how == "killed" else signal.SIGSTOP)
    time.sleep(FROZEN)
    held = sum(stands(state) for state in rider.states[number:])
    if how == "frozen":
        _wake(process)
    rider.stick = 0.0
    asked, before = time.monotonic(), len(rider.messages)
    rider.say(SetGoal(id=1, point=(11.0, 7.0)))
    answered = False
    while not answered and time.monotonic() - asked < PATIENCE:
        wish = RouteWish(kind="attract", points=((6.0, 9.0),))
        rider.say(PlanTrip(id=2, point=(11.0, 7.0), wishes=(wish,)))
        # A further request of the page would replace one that still waits.
        until = time.monotonic() + 10.0
        while not answered and time.monotonic() < until:
            time.sleep(0.05)
            answered = any(m.type == "trip_plans" for m in rider.messages[before:])
    rider.say(SetGoal(id=3))
    # Without an answer the whole patience counts.
    return held, time.monotonic() - asked


def _wake(process: int) -> None:
    with contextlib.suppress(ProcessLookupError):  # it was replaced meanwhile
        os.kill(process, signal.SIGCONT)


def previews() -> int:
    """Return the id of the previews' process."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        for each in multiprocessing.active_children():
            if each.name == "cohelm-previews" and each.pid is not None:
                return each.pid
        time.sleep(0.1)
    raise TimeoutError


@dataclass
class Figures:
    """What the interruptions of one kind, ``killed`` or ``frozen``, led to."""

    took: list[float] = field(default_factory=list)
    """Time to zero at the wheels, s, for each lost navigator."""
    confirmed: list[int] = field(default_factory=list)
    """Confirmations afterwards."""
    held: list[int] = field(default_factory=list)
    """Control steps that stood, for each lost process of previews."""
    answers: list[float] = field(default_factory=list)
    """Time to the next answer, s."""

    def add(self, rider: Rider, how: str, part: str) -> None:
        """Interrupt the processes of ``part`` once."""
        if part != "previews":
            seconds, count = interrupt_navigator(rider, how)
            self.took.append(seconds)
            self.confirmed.append(count)
        if part != "navigator":
            stops, answer = interrupt_previews(rider, how)
            self.held.append(stops)
            self.answers.append(answer)

    def show(self, how: str) -> None:
        """Print what was measured."""
        if self.took:
            print(
                f"navigator {how} {len(self.took)} times: zero after median "
                f"{np.median(self.took):.3f} s, max {max(self.took):.3f} s; "
                f"confirmations afterwards: max {max(self.confirmed)}"
            )
        if self.held:
            print(
                f"previews {how} {len(self.held)} times: {sum(self.held)} of "
                f"{round(len(self.held) * FROZEN * 20)} steps stood; answer after median "
                f"{np.median(self.answers):.1f} s, max {max(self.answers):.1f} s"
            )


def main() -> int:
    """Interrupt and print the figures; 1 if the chair did not stand in time."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--times", type=int, default=50)
    options.add_argument("--seconds", type=float, default=1e9, help="end earlier")
    options.add_argument("--part", choices=("all", "navigator", "previews"), default="all")
    chosen = options.parse_args()
    drive = Drive(DriveSetup(scenario=load_scenario("empty")))
    drive.start()
    rider = Rider(drive)
    figures = {"killed": Figures(), "frozen": Figures()}
    try:
        while not drive.health.ready:
            time.sleep(0.1)
        began = time.monotonic()
        rider.say(TakeControl())
        rider.say(SetMode(id=9, mode=Mode.STOP_ONLY))
        for _ in range(chosen.times):
            for how, each in figures.items():
                if time.monotonic() - began < chosen.seconds:
                    each.add(rider, how, chosen.part)
    except TimeoutError as ends:  # what was measured counts
        print(f"ended early: {ends}")
    finally:
        health = drive.health
        rider.close()
        drive.close()
    for how, each in figures.items():
        each.show(how)
    print(json.dumps({"restarts": health.restarts, "missed": health.missed, "rate": health.rate}))
    return int(max(max(each.took, default=0.0) for each in figures.values()) > 0.4)


if __name__ == "__main__":
    raise SystemExit(main())
