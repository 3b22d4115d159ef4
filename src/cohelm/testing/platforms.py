"""Contracts of ``platforms.PlatformPlugin`` and ``platforms.Platform``."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from cohelm.arrays import identical
from cohelm.messages import Decision, Observation
from cohelm.platforms import Capabilities, Platform, PlatformPlugin
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.testing.conformance import require

STEP = 0.05
"""Control period of a ride, s."""
MAX_CALL = 0.02
"""Maximum median duration of ``observe`` and of ``apply``, s: both belong to one control period.

The median, because a busy computer delays some calls and a slow platform delays every one.
"""
_RIDE = "empty"
_CREEP = 0.2
"""Speed of the test drive, m/s."""


def check_platform(plugin: PlatformPlugin) -> None:
    """Check a platform plugin; a simulated one also drives, twice, with equal results.

    A plugin of a real chair is opened by its own tests, which then call
    :func:`check_open_platform`.

    Raises:
        ConformanceError: naming the violated rule.
    """
    require(isinstance(getattr(plugin, "simulated", None), bool), "simulated must be True or False")
    require(callable(getattr(plugin, "open", None)), "a platform plugin must have open()")
    if not plugin.simulated:
        return
    setup = build_scenario(load_scenario(_RIDE), 0)
    rides = []
    for _ in range(2):
        platform = plugin.open(setup)
        require(platform.capabilities.world is not None, "simulated, but without a world")
        rides.append(check_open_platform(platform))
    require(identical(rides[0], rides[1]), "equal rides must give equal observations")


def check_open_platform(
    platform: Platform,
    *,
    seconds: float = 1.0,
    wait: Callable[[float], None] = lambda _: None,
) -> tuple[Observation, ...]:
    """Check an open platform: stand, creep forward at 0.2 m/s, stop, close. The chair moves.

    Args:
        platform: At rest, with a free metre ahead.
        seconds: Duration of each of the three parts, s.
        wait: Waits for a number of seconds; ``time.sleep`` for a chair in real time.

    Returns:
        All observations.

    Raises:
        ConformanceError: naming the violated rule.
    """
    capabilities = platform.capabilities
    require(bool(capabilities.name), "a platform must have a name")
    _check_wait(capabilities)
    creep = Decision(twist=np.array([_CREEP, 0.0, 0.0]))
    seen: list[Observation] = []
    spent: dict[str, list[float]] = {"observe": [], "apply": []}
    steps = round(seconds / STEP)
    for decision in (stop(Reason.STARTING), creep, stop(Reason.STARTING)):
        for _ in range(steps):
            began = time.perf_counter()
            seen.append(platform.observe())
            observed = time.perf_counter()
            platform.apply(decision)
            applied = time.perf_counter()
            spent["observe"].append(observed - began)
            spent["apply"].append(applied - observed)
            wait(max(STEP - (applied - began), 0.0))
    require(platform.capabilities is capabilities, "capabilities must stay the same")
    for name, durations in spent.items():
        typical = float(np.median(durations))
        require(typical <= MAX_CALL, f"{name} takes {1e3 * typical:.1f} ms, allowed are 20 ms")
    _check_times(seen)
    _check_motion(seen, steps)
    platform.close()
    platform.close()
    return tuple(seen)


def _check_wait(capabilities: Capabilities) -> None:
    """Check that the wait for a reading ends without one, in time."""
    if capabilities.wait is None:
        return
    began = time.monotonic()
    at = capabilities.wait(math.inf, STEP)
    spent = time.monotonic() - began
    require(at is None, "wait must return None where no reading is later than 'after'")
    require(spent <= 4.0 * STEP, f"wait must end at its timeout; it took {spent:.2f} s")


def _check_times(seen: list[Observation]) -> None:
    times = np.array([each.time for each in seen])
    require(np.isfinite(times).all(), "time must be finite")
    require((np.diff(times) >= 0.0).all(), "time must never run backwards")
    elapsed = times[-1] - times[0]
    expected = (len(seen) - 1) * STEP
    require(
        abs(elapsed - expected) <= 0.2 * expected,
        f"time must pass as in the control loop: {elapsed:.2f} s instead of {expected:.2f} s",
    )
    for each in seen:
        stamps = [each.pose_time, each.twist_time]
        stamps += [scan.time for scan in each.scans] + [cloud.time for cloud in each.clouds]
        require(max(stamps) <= each.time + STEP, "no stamp may lie in the future")
    readings = [(scan.time, *scan.mount) for each in seen for scan in each.scans]
    require(len(set(readings)) == len(readings), "a scan must be observed once, not repeated")


def _check_motion(seen: list[Observation], steps: int) -> None:
    """Check that the chair moves when commanded, forwards, and that odometry agrees with pose."""
    first, last = seen[steps].pose, seen[-1].pose
    heading = first[2]
    ahead = float((last[:2] - first[:2]) @ np.array([np.cos(heading), np.sin(heading)]))
    require(ahead > 0.0, f"a forward command must move the chair forward; it moved {ahead:.2f} m")
    still = float(np.hypot(*(seen[steps - 1].pose[:2] - seen[0].pose[:2])))
    require(still < 0.05, f"a stop must not move the chair; it moved {still:.2f} m")
    driven = sum(float(each.twist[0]) for each in seen) * STEP
    require(
        abs(driven - ahead) <= 0.1 + 0.3 * ahead,
        f"odometry reports {driven:.2f} m, the localiser {ahead:.2f} m",
    )
