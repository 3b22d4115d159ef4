"""Health monitor: one pure function that compares what is redundant in the input of a chair.

    scan against itself       invalid, stuck or repeated readings; a blind sector ahead
    cloud against itself      repeated frames, covered lenses
    scan against map          is the pose right, as seen by beams that contradict the map
    scan against earlier one  a view that breaks off, objects that vanish
    scan against wheels       does the world move as odometry and localiser say
    pose against wheels       drift and jumps of either
    command against motion    motors and brakes that are weak, dead or stuck
    stick against its past    a deflection that never changes

What is doubtful slows the chair, what contradicts stops it; see ``health.evidence`` for the times.

The file goes from the smaller comparisons to the whole: the view in the direction of travel, the
localisation, the drive, the monitor.

Command against motion: two first-order models with ramps follow the command: a quick one with the
hardest ramps and half the lag, and a slow one with weak ramps and a delay. Measured speeds outside
the band of both are integrated; an integral beyond its bound is a fault.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, replace
from cohelm.health.agreement import MotionHistory, disagreement, update_motion
from cohelm.health.clouds import CloudState, cloud_symptoms, update_clouds
from cohelm.health.evidence import (
    NO_EVIDENCE,
    Evidence,
    findings,
    update_evidence,
    without_latched,
)
from cohelm.health.map_changes import (
    NO_CHANGES,
    MapChanges,
    standing_people,
    update_map_changes,
    without_people,
)
from cohelm.health.map_fit import MISSING, UNUSABLE, MapFit, SolidMap
from cohelm.health.parameters import HealthParameters
from cohelm.health.stick import StickHistory, update_stick
from cohelm.health.sweeps import PosesAtSweep, ScannerState, update_scanner
from cohelm.health.values import Health, LocalisationHealth, LocalisationState
from cohelm.kernels import CACHED, callee
from cohelm.messages import Mode, Observation, Reason, Request, Scan
from cohelm.robots import Robot, move

_MAX_GAP = 0.25
"""Time between two observations after which the band begins anew, s."""
_WEAK = 0.75
"""Share of the stated ramps that a sound drive reaches at least."""
_STRONG = 1.3
_WINDOW = 1.0
"""Time constant in which excess is forgotten, s."""


class AxisBand(NamedTuple):
    """Band of one component of the twist, and what was measured outside it."""

    quick: float
    slow: float
    slow_command: float
    """Command as the slow model receives it."""
    over: float = 0.0
    """Integral of motion that the command does not explain, m or rad."""
    lacking: float = 0.0
    """Integral of commanded motion that is missing, m or rad."""


class DriveBand(NamedTuple):
    """Memory of the comparison."""

    time: float
    linear: AxisBand
    angular: AxisBand


def update_drive(
    memory: DriveBand | None, observation: Observation, robot: Robot, p: HealthParameters
) -> tuple[DriveBand | None, Reason | None]:
    """Compare the measured twist with the commands so far.

    Returns:
        (memory for the next call, symptom or None).
    """
    command = observation.command
    v, w = float(observation.twist[0]), float(observation.twist[2])
    now = observation.time
    if command is None:
        return None, None
    if memory is None or not 0.0 < now - memory.time <= _MAX_GAP:
        start = (AxisBand(v, v, v), AxisBand(w, w, w))
        return DriveBand(now, *start), None
    dt, lag = now - memory.time, robot.actuation_lag
    linear = AxisBand(
        *_follow(
            memory.linear,
            float(command[0]),
            v,
            dt,
            lag,
            (robot.max_acceleration, robot.max_deceleration, robot.emergency_deceleration),
            p.drive_margin,
        )
    )
    turn = robot.max_turn_acceleration
    angular = AxisBand(
        *_follow(memory.angular, float(command[2]), w, dt, lag, (turn, turn, turn), p.turn_margin)
    )
    band = DriveBand(now, linear, angular)
    if linear.over > p.drive_excess or angular.over > 2.0 * p.drive_excess:
        return band, Reason.DRIVE_FAULT
    if linear.lacking > 8.0 * p.drive_excess:
        return band, Reason.DRIVE_FAULT
    if linear.lacking > 1.2 * p.drive_excess or angular.lacking > 4.0 * p.drive_excess:
        return band, Reason.DRIVE_WEAK
    return band, None


@njit(**CACHED)
def _follow(
    band: AxisBand,
    command: float,
    measured: float,
    dt: float,
    lag: float,
    ramps: tuple[float, float, float],
    margin: tuple[float, float],
) -> tuple[float, float, float, float, float]:
    rise, fall, hardest = ramps
    quick = _ramped(band.quick, command, _STRONG * rise * dt, _STRONG * hardest * dt)
    delayed = band.slow_command + (command - band.slow_command) * (
        1.0 - math.exp(-dt / (1.5 * lag + 0.08))
    )
    slow = _ramped(band.slow, delayed, _WEAK * rise * dt, _WEAK * fall * dt)
    low, high = min(quick, slow), max(quick, slow)
    allowed = margin[0] + margin[1] * max(abs(low), abs(high))
    above, below = measured - high - allowed, low - allowed - measured
    # Motion against the band or beyond it is not commanded; motion short of it is lacking.
    over, lacking = 0.0, 0.0
    if above > 0.0:
        over, lacking = (above, 0.0) if high >= 0.0 or measured > 0.0 else (0.0, above)
    elif below > 0.0:
        over, lacking = (below, 0.0) if low <= 0.0 or measured < 0.0 else (0.0, below)
    keep = math.exp(-dt / _WINDOW)
    over = keep * band.over + over * dt if over > 0.0 else keep * band.over
    lacking = keep * band.lacking + lacking * dt if lacking > 0.0 else keep * band.lacking
    return quick, slow, delayed, over, lacking


@callee()
def _ramped(value: float, target: float, rise: float, fall: float) -> float:
    """Value that approaches the target: away from zero by ``rise``, towards zero by ``fall``."""
    if target > value:
        return min(target, value + (rise if value >= 0.0 else fall))
    return max(target, value - (rise if value <= 0.0 else fall))


_MIN_MISSING = 4
"""Beams of a run of free ones that must miss a wall for the whole run not to be believed."""
_MISSING_SHARE = 0.15
BINS = 120
"""Directions about the robot, 3° each."""


def widest_gap(
    scanners: Iterable[tuple[ScannerState, Floats]],
    travel: float,
    half_angle: float,
    *,
    trust_map: bool,
) -> float:
    """Width of the widest unseen gap in the sector of travel, rad.

    Directions that no scanner covers by design do not count: the gap is a loss. A beam that finds
    nothing where the map has a wall sees nothing, if the map is trusted.

    Args:
        scanners: last sweep and mount (3,) of each.
        travel: direction of travel in the robot's frame, rad.
        half_angle: half the sector, rad.
        trust_map: compare with the map.
    """
    seen, covered = np.zeros(BINS, dtype=np.bool_), np.zeros(BINS, dtype=np.bool_)
    for state, mount in scanners:
        lost = state.fit.beams == UNUSABLE
        if trust_map:
            lost |= _disbelieved(state)
        angle = (state.beams.angle + mount[2]) % (2.0 * math.pi)
        index = (angle / (2.0 * math.pi) * BINS).astype(np.int64) % BINS
        covered[index] = True
        seen[index[~lost]] = True
    blind = covered & ~seen
    if not blind.any():
        return 0.0
    directions = (np.arange(BINS) + 0.5) * 2.0 * math.pi / BINS
    apart = np.abs((directions - travel + math.pi) % (2.0 * math.pi) - math.pi)
    return _longest_run(blind & (apart <= half_angle)) * 2.0 * math.pi / BINS


def _disbelieved(state: ScannerState) -> Booleans:
    """Mask of the free beams that see nothing.

    A run of free beams that misses mapped walls in a part of it is not believed in any part.
    """
    free: Booleans = np.isposinf(state.beams.range)
    missing: Booleans = state.fit.beams == MISSING
    if free.all():
        return np.asarray(free & missing.any())
    if missing.sum() < _MIN_MISSING:
        return missing
    start = int(np.argmin(free))
    rolled, missed = np.roll(free, -start), np.roll(missing, -start)
    run = np.cumsum(~rolled)  # beams of one run of free ones share a number
    count = np.bincount(run[rolled], minlength=run[-1] + 1)
    wrong = np.bincount(run[rolled & missed], minlength=run[-1] + 1)
    whole = (wrong >= _MIN_MISSING) & (wrong >= _MISSING_SHARE * count)
    return np.asarray(missing | np.roll(rolled & whole[run], start))


def _longest_run(mask: Booleans) -> int:
    """Length of the longest run of a circular mask; a single seen bin does not interrupt it."""
    closed = mask | (np.roll(mask, 1) & np.roll(mask, -1))
    if closed.all():
        return len(closed)
    start = int(np.argmin(closed))
    best = run = 0
    for each in np.roll(closed, -start).tolist():
        run = run + 1 if each else 0
        best = max(best, run)
    return best


_MIN_BEAMS = 10
"""Informative beams without which a sweep judges nothing."""
_GOOD, _DOUBTFUL = LocalisationState.GOOD, LocalisationState.DOUBTFUL
_LOST, _UNKNOWN = LocalisationState.LOST, LocalisationState.UNKNOWN


def update_localisation(
    before: LocalisationHealth,
    fit: MapFit,
    elapsed: float,
    time: float,
    p: HealthParameters,
    *,
    carried: bool = False,
) -> LocalisationHealth:
    """Add the fit of a sweep; one that shows too little of the map changes nothing.

    Args:
        before: health before.
        fit: of the sweep.
        elapsed: time since the last sweep, s.
        time: of the sweep, s.
        p: parameters.
        carried: the view broke off, and less of it is on the map since.
    """
    enough = fit.hit + fit.through + fit.missing >= _MIN_BEAMS
    if fit.informative < p.min_informative or not enough:
        state = _LOST if carried else before.state
        return _with(before, state, before.contradiction, before.offset, fit, time)
    share = 1.0 if before.state is _UNKNOWN else 1.0 - math.exp(-elapsed / p.smoothing)
    contradiction = before.contradiction + share * (fit.contradiction - before.contradiction)
    offset = fit.offset if fit.gain >= p.min_gain else np.zeros(3)
    offset = before.offset + share * (offset - before.offset)
    state = _LOST if carried else _state(contradiction, offset, p)
    return _with(before, state, contradiction, offset, fit, time)


def stated_doubt(observation: Observation, p: HealthParameters) -> bool:
    """Check the covariance that the localiser states for its own pose."""
    covariance = observation.pose_covariance
    if covariance is None:
        return False
    return not float(np.sqrt(np.trace(covariance[:2, :2]) / 2.0)) < p.doubtful_deviation


def _state(contradiction: float, offset: np.ndarray, p: HealthParameters) -> LocalisationState:
    far, turn = math.hypot(offset[0], offset[1]), abs(float(offset[2]))
    if contradiction >= p.lost_share or far >= p.lost_offset or turn >= p.lost_turn:
        return _LOST
    if contradiction >= p.doubtful_share or far >= p.doubtful_offset or turn >= p.doubtful_turn:
        return _DOUBTFUL
    return _GOOD


def _with(
    before: LocalisationHealth,
    state: LocalisationState,
    contradiction: float,
    offset: np.ndarray,
    fit: MapFit,
    time: float,
) -> LocalisationHealth:
    return LocalisationHealth(
        state=state,
        contradiction=contradiction,
        informative=fit.informative,
        offset=offset,
        since=before.since if state is before.state else time,
    )


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
    clouds: tuple[CloudState, ...] = ()
    """One for each LiDAR and depth camera that has sent."""
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
        changes = without_people(changes, np.concatenate([people[:, :2], standing[:, :2]]))
    symptoms = [each for each in (drive_symptom, stick_symptom) if each is not None]
    fresh = [s for s in scanners if s is not None and observation.time - s.time <= _FRESH]
    symptoms += _scan_symptoms(scanners, observation, robot, localisation, p)
    clouds = update_clouds(memory.clouds, observation, p)
    symptoms += cloud_symptoms(clouds, observation.time)
    symptoms += _motion_symptoms(fresh, motion, localisation, observation, p)
    evidence = update_evidence(memory.evidence, symptoms, observation.time)
    state = HealthState(
        scanners=scanners,
        clouds=clouds,
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
