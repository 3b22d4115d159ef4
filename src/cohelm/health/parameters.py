"""Parameters of the health monitor; assumed where no reason is given."""

from __future__ import annotations

import math

from pydantic import Field

from cohelm.config import Model


class HealthParameters(Model):
    """Bounds beyond which redundant input counts as contradictory."""

    enabled: bool = True
    """Let findings slow and stop the chair; False: only report them."""
    slow: float = Field(0.3, gt=0.0, le=3.0)
    """Speed limit while something is doubtful, m/s."""

    # One sweep by itself.
    beams: int = Field(120, ge=20, le=2000)
    """Beams compared with the map; more cost time."""
    invalid_share: float = Field(0.4, gt=0.0, le=1.0)
    """Share of beams without a believable reading from which a sweep is implausible."""
    repeated_share: float = Field(0.9, gt=0.0, le=1.0)
    """Share of returns equal to the sweep before, to the last bit, from which it repeats it."""

    # View in the direction of travel.
    view_half_angle: float = Field(0.7, gt=0.0, le=math.pi)
    """Half the sector about the direction of travel that must be seen, rad."""
    blind_gap: float = Field(0.3, gt=0.0, le=math.pi)
    """Width of an unseen part of it that stops the chair, rad: a person at 2 m is 0.25 rad wide."""
    narrow_gap: float = Field(0.15, gt=0.0, le=math.pi)
    """Width that slows it, rad."""

    # Scan against map.
    wall_tolerance: float = Field(0.15, gt=0.0, le=1.0)
    """Distance from a mapped wall within which a return lies on it, m."""
    min_informative: float = Field(0.12, gt=0.0, le=1.0)
    """Share of beams that must reach mapped walls for a judgement: a crowd may hide the rest."""
    doubtful_share: float = Field(0.12, gt=0.0, le=1.0)
    """Share of contradicting beams from which the position is doubtful."""
    lost_share: float = Field(0.2, gt=0.0, le=1.0)
    """Share from which it is lost."""
    doubtful_offset: float = Field(0.18, gt=0.0, le=5.0)
    """Offset of the best fit from which the position is doubtful, m."""
    lost_offset: float = Field(0.35, gt=0.0, le=5.0)
    """Offset from which it is lost, m."""
    doubtful_turn: float = Field(0.07, gt=0.0, le=math.pi)
    """Turn of the best fit from which the position is doubtful, rad."""
    lost_turn: float = Field(0.14, gt=0.0, le=math.pi)
    """Turn from which it is lost, rad."""
    break_drop: float = Field(0.25, gt=0.0, le=1.0)
    """Fall of the share of a sweep that continues the earlier one at which the view breaks off; in
    sound drives one sweep in a thousand falls by 0.2."""
    break_fall: float = Field(0.08, gt=0.0, le=1.0)
    """Fall of the share of beams on mapped walls, from before a break, with which the pose is
    lost."""
    min_gain: float = Field(0.08, ge=0.0, le=1.0)
    """Additional share of returns that the best fit must explain for its offset to count."""
    smoothing: float = Field(0.4, gt=0.0, le=10.0)
    """Time constant of share and offset, s."""
    registration_shift: float = Field(0.06, ge=0.0, le=0.3)
    """Largest shift of the pose towards the best fit, m: twice the error of a good localiser; with
    this and the turn at 0 the pose is used as reported."""
    registration_turn: float = Field(0.035, ge=0.0, le=0.2)
    """Largest turn of the pose towards the best fit, rad."""
    registration_hits: float = Field(0.3, gt=0.0, le=1.0)
    """Share of beams that must end on mapped walls for it."""
    doubtful_deviation: float = Field(0.3, gt=0.0, le=10.0)
    """Standard deviation stated by the localiser from which the position is doubtful, m."""

    # Pose, odometry and sweeps against each other, over windows of time.
    short_window: float = Field(1.0, gt=0.0, le=10.0)
    """s."""
    long_window: float = Field(4.0, gt=0.0, le=60.0)
    """s."""
    short_difference: tuple[float, float] = (0.13, 0.12)
    """Difference of two motions over the short window: m, and share of the distance."""
    long_difference: tuple[float, float] = (0.16, 0.06)
    """The same over the long window."""
    turn_difference: tuple[float, float] = (0.08, 0.1)
    """Difference of two turns: rad, and share of the turn."""
    match_difference: tuple[float, float] = (0.1, 0.15)
    """Difference of a motion from the one between two sweeps: m, and share of the distance."""
    min_inliers: float = Field(0.55, gt=0.0, le=1.0)
    """Share of a sweep's points that must fit the earlier sweep for a motion to be estimated."""
    lost_inliers: float = Field(0.15, gt=0.0, le=1.0)
    """Share below which a sweep does not continue the earlier one at all."""

    # Command against motion.
    drive_margin: tuple[float, float] = (0.06, 0.08)
    """Speed outside the expected band that is no fault: m/s, and share of the speed."""
    turn_margin: tuple[float, float] = (0.15, 0.15)
    """The same for turns, rad/s."""
    drive_excess: float = Field(0.04, gt=0.0, le=5.0)
    """Integral of the speed outside the band that is a fault, m; turns count in rad."""

    # Stick against its own history.
    stuck_time: float = Field(8.0, gt=0.0, le=600.0)
    """Time for which a deflection that never changes holds a standing chair, s."""
