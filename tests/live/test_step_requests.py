"""Readings of skipped steps reach the navigator; a command that it missed does not."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.live.control.step_requests import MAX_SKIPPED, UnsentReadings
from cohelm.messages import Observation, Scan

SCAN = Scan(
    time=0.0, mount=np.zeros(3), angle_min=0.0, angle_increment=0.1, range_max=5.0,
    ranges=np.ones(3),
)  # fmt: skip
SEEN = Observation(
    time=0.0, pose=np.zeros(3), pose_time=0.0, twist=np.array([0.6, 0.0, 0.0]), twist_time=0.0,
    command=np.zeros(3), scans=(SCAN,),
)  # fmt: skip


@pytest.mark.parametrize("skipped", [0, 1, MAX_SKIPPED, 5])
def test_after_several_skipped_steps_the_command_is_unknown(skipped):
    """A stop by the watchdog in between is no fault of the drive."""
    unsent = UnsentReadings()
    for _ in range(skipped):
        unsent.keep(SEEN)
    taken = unsent.take(SEEN)
    assert len(taken.scans) == skipped + 1
    assert (taken.command is None) == (skipped >= MAX_SKIPPED)
    assert unsent.take(replace(SEEN)).command is not None  # from then on it is known again
