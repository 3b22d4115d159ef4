"""Parameters of the recovery."""

from __future__ import annotations

from pydantic import Field

from cohelm.config import Model


class RecoveryParameters(Model):
    """Durations of the stages; assumed. ``ProgressParameters.time_allowance`` starts the first."""

    wait: float = Field(1.0, ge=0.0, le=120.0)
    """Waiting time if no person is near, s."""
    wait_for_people: float = Field(2.0, ge=0.0, le=120.0)
    """Waiting time if a person stands near, s."""
    wait_for_walking_people: float = Field(8.0, ge=0.0, le=120.0)
    """Waiting time while a person walks near, who will soon be gone, s."""
    wait_at_goal: float = Field(10.0, ge=0.0, le=600.0)
    """Waiting time for a person who stands at the goal, s; then the chair tries to come closer, and
    asks the rider."""
    people_radius: float = Field(3.0, ge=0.0, le=20.0)
    """Distance within which people are waited for, m."""
    walking_speed: float = Field(0.3, ge=0.0, le=3.0)
    """Speed above which a person walks, m/s."""
    standstill: float = Field(0.5, ge=0.0, le=10.0)
    """A new path on which the chair stands this long does not help, s."""
    new_path_time: float = Field(6.0, ge=0.0, le=120.0)
    """Time allowance of a new path while the chair moves, s."""
    back_up: float = Field(0.4, ge=0.0, le=0.5)
    """Maximum distance to back up, m; 0: never."""
    min_back_up: float = Field(0.1, gt=0.0, le=0.5)
    """Minimum rear clearance for backing up, m."""
    back_up_speed: float = Field(0.2, gt=0.0, le=1.0)
    """m/s; at most ``progress.creep_speed``."""
    back_up_time: float = Field(4.0, ge=0.0, le=30.0)
    """Time allowance of backing up, s."""
    trail_time: float = Field(8.0, ge=0.0, le=120.0)
    """Places that the chair itself occupied within this time count as free, s."""
    creep: float = Field(8.0, ge=0.0, le=120.0)
    """Time of creeping before the rider is asked, s."""
    replan_interval: float = Field(5.0, gt=0.0, le=120.0)
    """Time between replanning attempts while the rider is asked, s."""
    clear_distance: float = Field(1.0, gt=0.0, le=10.0)
    """Distance from the place where it got stuck at which the chair is clear of it, m."""
    input_delay: float = Field(1.0, ge=0.0, le=30.0)
    """Rider input is followed after the chair stood without progress for this time, s."""
    side_deflection: float = Field(0.2, ge=0.0, le=1.0)
    """Lateral deflection that selects a passing side, share of full."""
