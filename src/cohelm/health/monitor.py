"""Health monitor: one pure function that compares what is redundant in the input of a chair.

    scan against itself       invalid, stuck or repeated readings; a blind sector ahead
    scan against map          is the pose right, as seen by beams that contradict the map
    scan against wheels       does the world move as odometry and localiser say
    pose against wheels       drift and jumps of either
    command against motion    motors and brakes that are weak, dead or stuck
    stick against its past    a deflection that never changes

What is doubtful slows the chair, what contradicts stops it; see ``health.evidence`` for the times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.health.agreement import MotionHistory, disagreement, update_motion
from cohelm.health.drive_response import DriveBand, update_drive
from cohelm.health.evidence import (
    NO_EVIDENCE,
    Evidence,
    findings,
    update_evidence,
    without_latched,
)
from cohelm.health.localisation import stated_doubt, update_localisation
from cohelm.health.map_changes import (
    NO_CHANGES,
    MapChanges,
    standing_people,
    update_map_changes,
    without_people,
)
from cohelm.health.map_fit import SolidMap
from cohelm.health.parameters import HealthParameters
from cohelm.health.stick import StickHistory, update_stick
from cohelm.health.sweeps import PosesAtSweep, ScannerState, update_scanner
from cohelm.health.values import Health, LocalisationHealth, LocalisationState
from cohelm.health.view_ahead import widest_gap
from cohelm.messages import Mode, Observation, Reason, Request, Scan
from cohelm.robots import Robot, move

_SETTLED = 1.0
"""Time for which the pose must fit the map after a jump, s."""
_FRESH = 0.5
"""Age up to which the results of a sweep hold, s; later the safety gate has stopped the chair."""
_UNPLACED = 0.15
"""Time before the comparison of pose and odometry began at which a sweep is not placed, s: of a
sweep from a gap between two observations it is not known where the chair was."""
_MOVING = 0.03
"""m/s."""
_MANUAL = frozenset({Reason.DRIVE_FAULT, Reason.DRIVE_WEAK, Reason.STICK_STUCK})
"""Reasons that act in ``Mode.MANUAL``, where distance and place are the rider's responsibility."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HealthState:
    """Memory of the monitor."""

    scanners: tuple[ScannerState | None, ...] = ()
    """One for each planar scanner of the robot."""
    motion: MotionHistory | None = None
    drive: DriveBand | None = None
    stick: StickHistory | None = None
    localisation: LocalisationHealth = field(default_factory=LocalisationHealth)
    evidence: Evidence = field(default_factory=lambda: NO_EVIDENCE)
    changes: MapChanges = NO_CHANGES
    standing: Floats = field(default_factory=lambda: np.empty((0, 3)))
    """See :func:`~cohelm.health.map_changes.standing_people`."""


def monitor(
    observation: Observation,
    request: Request,
    robot: Robot,
    known: SolidMap,
    memory: HealthState | None,
    parameters: HealthParameters,
    *,
    people: Floats | None = None,
) -> tuple[Health, HealthState]:
    """Judge an observation that has passed the checks of the safety gate.

    Args:
        observation: of this instant.
        request: its mode decides which findings act.
        robot: its scanners, ramps and lag.
        known: the map, see :func:`~cohelm.health.map_fit.beam_map`.
        memory: of the last call; None at first.
        parameters: bounds.
        people: positions and velocities (n, 4) of the people seen last, m and m/s: neither they nor
            those who stood there lately are a change of the map.

    Returns:
        (health, memory for the next call).
    """
    p, memory = parameters, memory or HealthState()
    motion = update_motion(memory.motion, observation, p)
    drive, drive_symptom = update_drive(memory.drive, observation, robot, p)
    stick, stick_symptom = update_stick(memory.stick, observation, request, p)
    scanners, localisation, changes = _update_scanners(observation, robot, known, motion, memory, p)
    standing = memory.standing
    if people is not None:
        standing = standing_people(standing, people, observation.time)
        changes = without_people(changes, np.vstack([people[:, :2], standing[:, :2]]))
    symptoms = [each for each in (drive_symptom, stick_symptom) if each is not None]
    fresh = [s for s in scanners if s is not None and observation.time - s.time <= _FRESH]
    symptoms += _scan_symptoms(scanners, observation, robot, localisation, p)
    symptoms += _motion_symptoms(fresh, motion, localisation, observation, p)
    evidence = update_evidence(memory.evidence, symptoms, observation.time)
    state = HealthState(
        scanners=scanners,
        motion=motion,
        drive=drive,
        stick=stick,
        localisation=localisation,
        evidence=evidence,
        changes=changes,
        standing=standing,
    )
    return _health(evidence, localisation, request, p), state


def acknowledged(memory: HealthState) -> HealthState:
    """Memory after STOP was pressed, which ends latched findings."""
    return replace(memory, evidence=without_latched(memory.evidence))


def _update_scanners(
    observation: Observation,
    robot: Robot,
    known: SolidMap,
    motion: MotionHistory,
    memory: HealthState,
    p: HealthParameters,
) -> tuple[tuple[ScannerState | None, ...], LocalisationHealth, MapChanges]:
    """Check the new sweeps of each scanner; the newest one of each judges the pose."""
    scanners = list(memory.scanners or (None,) * len(robot.lasers))
    localisation, changes = memory.localisation, memory.changes
    for scan in observation.scans:
        if not len(scan.ranges) or not scanners:
            continue
        i = _scanner_of(scan, robot)
        before = scanners[i]
        if before is not None and scan.time <= before.time:
            continue
        if scan.time < motion.rows[0, 0] - _UNPLACED:
            continue
        since = scan.time - observation.pose_time
        at = PosesAtSweep(
            move(observation.pose, observation.twist, since),
            move(motion.odometry, observation.twist, scan.time - observation.time),
            jumped=before is not None and motion.jumped > before.time,
        )
        now = update_scanner(before, scan, at, known, p)
        elapsed = scan.time - before.time if before else p.smoothing
        carried = now.continuity.fall >= p.break_fall
        localisation = update_localisation(
            localisation, now.fit, elapsed, scan.time, p, carried=carried
        )
        if localisation.state is LocalisationState.GOOD:
            changes = update_map_changes(
                changes, now.fit, now.beams, at.reported, scan.mount, scan.time
            )
        scanners[i] = now
    return tuple(scanners), localisation, changes


def _scanner_of(scan: Scan, robot: Robot) -> int:
    """Index of the robot's scanner whose mount is nearest to the stated one."""
    if len(robot.lasers) == 1:
        return 0
    apart = np.abs(np.array([m.pose for m in robot.lasers]) - scan.mount).sum(axis=1)
    return int(np.argmin(apart))


def _scan_symptoms(
    scanners: tuple[ScannerState | None, ...],
    observation: Observation,
    robot: Robot,
    localisation: LocalisationHealth,
    p: HealthParameters,
) -> list[Reason]:
    """Symptoms of the sweeps by themselves, and of the view ahead."""
    out = []
    fresh = (
        [
            (state, np.array(mount.pose))
            for state, mount in zip(scanners, robot.lasers, strict=True)
            if state is not None and observation.time - state.time <= _FRESH
        ]
        if scanners
        else []
    )
    for state, _ in fresh:
        missing = state.fit.missing / max(len(state.beams.angle), 1)
        if max(state.check.invalid, missing) >= p.invalid_share:
            out.append(Reason.SCAN_IMPLAUSIBLE)
        if state.check.repeated >= p.repeated_share:
            out.append(Reason.SCAN_FROZEN)
    if not fresh:
        return out
    trust_map = localisation.state is not LocalisationState.UNKNOWN
    gap = widest_gap(fresh, _travel(observation), p.view_half_angle, trust_map=trust_map)
    if gap >= p.blind_gap:
        out.append(Reason.SCAN_BLIND)
    elif gap >= p.narrow_gap:
        out.append(Reason.SCAN_PARTLY_BLIND)
    return out


def _travel(observation: Observation) -> float:
    """Direction of travel in the robot's frame, rad; ahead for a standing chair."""
    for twist in (observation.twist, observation.command):
        if twist is not None and math.hypot(twist[0], twist[1]) > _MOVING:
            return math.atan2(twist[1], twist[0])
    return 0.0


def _motion_symptoms(
    fresh: list[ScannerState],
    motion: MotionHistory,
    localisation: LocalisationHealth,
    observation: Observation,
    p: HealthParameters,
) -> list[Reason]:
    """Symptoms of motions and places that do not agree."""
    out = []
    state, now = localisation.state, observation.time
    settled = state is LocalisationState.GOOD and now - localisation.since >= _SETTLED
    unsettled = now - motion.jumped < _SETTLED or (motion.jumped > -math.inf and not settled)
    if state is LocalisationState.LOST:
        out.append(Reason.LOST)
    elif state is LocalisationState.DOUBTFUL or unsettled or stated_doubt(observation, p):
        out.append(Reason.POSE_DOUBTFUL)
    apart = disagreement(motion, p) >= 1.0
    matched = [s.agreement for s in fresh if s.agreement.matched]
    wheels = any(a.wheels >= 1.0 for a in matched)
    pose = any(a.pose >= 1.0 for a in matched)
    torn = any(s.agreement.torn for s in fresh) and not matched
    if torn or any(s.objects.vanished(s.time) for s in fresh):
        out.append(Reason.SCAN_MOTION)
    if wheels and pose:
        out.append(Reason.SENSORS_DISAGREE if apart else Reason.SCAN_MOTION)
    elif apart and (wheels or pose):
        out.append(Reason.ODOMETRY_FAULT if wheels else Reason.POSE_FAULT)
    elif apart:
        out.append(Reason.SENSORS_DISAGREE)
    return out


def _health(
    evidence: Evidence, localisation: LocalisationHealth, request: Request, p: HealthParameters
) -> Health:
    """Findings, and what they do in this mode."""
    found = findings(evidence)
    acting = found if p.enabled else ()
    if request.mode is Mode.MANUAL:
        acting = tuple(each for each in acting if each.reason in _MANUAL)
    stops = [each.reason for each in acting if each.stops]
    slows = [each.reason for each in acting if not each.stops]
    return Health(
        findings=found,
        localisation=localisation,
        speed_limit=p.slow if acting else math.inf,
        stop=stops[0] if stops else None,
        slow=slows[0] if slows else None,
    )
