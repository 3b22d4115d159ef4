"""Faults of motors, brakes and the way of the command to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.messages import Decision
from cohelm.simulation.drivetrain import DriveCommand
from cohelm.simulation.faults.api import SHARE, FaultKind
from cohelm.simulation.faults.fault import Fault

TRACK = 0.55
"""Distance between the driven wheels, m; assumed."""
_STANDING = Decision(twist=np.zeros(3))


def received(
    sent: Sequence[tuple[float, Decision]],
    faults: Iterable[Fault],
    time: float,
    rng: np.random.Generator,
    held: Decision,
) -> Decision:
    """Decision that the motor controller receives.

    Args:
        sent: times and decisions of the navigator, the newest last.
        faults: active ones.
        time: now, s.
        rng: of dropped commands.
        held: the last one that arrived.
    """
    decision = sent[-1][1]
    for fault in faults:
        if fault.kind == "command_stuck" or (
            fault.kind == "command_dropped" and rng.random() < fault.size
        ):
            decision = held
        elif fault.kind == "command_delayed":
            due = time - fault.size + 1e-9
            before = [each for at, each in sent if at <= due]
            decision = before[-1] if before else _STANDING
        elif fault.kind == "command_dead":
            decision = _STANDING
        elif fault.kind == "command_scaled":
            decision = replace(decision, twist=fault.size * decision.twist)
        elif fault.kind == "command_flipped":
            decision = replace(decision, twist=decision.twist * np.array([1.0, -1.0, -1.0]))
    return decision


def weakened(command: DriveCommand, faults: Iterable[Fault]) -> DriveCommand:
    """Command with the ramps of weak brakes or a weak battery."""
    for fault in faults:
        keep = max(1.0 - fault.size, 0.02)
        if fault.kind == "brake_slow":
            braking = None if command.braking is None else keep * command.braking
            command = replace(command, fall=keep * command.fall, braking=braking)
        elif fault.kind == "battery_sag":
            command = replace(command, target=keep * command.target, rise=keep * command.rise)
    return command


def true_twist(twist: Floats, faults: Iterable[Fault]) -> Floats:
    """Twist (3,) of the chair whose wheels should give ``twist``."""
    for fault in faults:
        keep = 1.0 - fault.size
        if fault.kind == "motor_weak":
            left = twist[0] - 0.5 * TRACK * twist[2]
            right = keep * (twist[0] + 0.5 * TRACK * twist[2])
            twist = np.array([0.5 * (left + right), twist[1], (right - left) / TRACK])
        elif fault.kind == "wheel_slip":
            twist = max(keep, 0.05) * twist
    return twist


DRIVE: Mapping[str, FaultKind] = MappingProxyType(
    {
        "command_stuck": FaultKind(text="wheels stuck on the last command"),
        "command_dead": FaultKind(text="actuator dead"),
        "command_delayed": FaultKind(
            text="command delayed",
            unit="s",
            typical=0.3,
            bounds=(0.0, 1.9),
            intensities=(0.15, 0.3, 0.6),
        ),
        "command_dropped": FaultKind(
            text="commands dropped",
            unit="share",
            typical=0.5,
            bounds=SHARE,
            intensities=(0.2, 0.5, 0.9),
        ),
        "command_scaled": FaultKind(
            text="command scaled",
            unit="factor",
            typical=1.5,
            bounds=(-5.0, 5.0),
            intensities=(0.5, 1.5, -1.0),
        ),
        "command_flipped": FaultKind(text="turns in the wrong direction"),
        "motor_weak": FaultKind(
            text="right motor weak",
            unit="share lost",
            typical=0.3,
            bounds=SHARE,
            intensities=(0.1, 0.3, 0.6),
        ),
        "brake_slow": FaultKind(
            text="brakes weak",
            unit="share lost",
            typical=0.5,
            bounds=SHARE,
            intensities=(0.3, 0.5, 0.8),
        ),
        "battery_sag": FaultKind(
            text="battery weak",
            unit="share lost",
            typical=0.3,
            bounds=SHARE,
            intensities=(0.3, 0.6),
        ),
    }
)
