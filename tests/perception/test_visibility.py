import numpy as np
import pytest

from cohelm.perception.tracking.association import (
    OCCLUDED,
    OCCUPIED,
    OUT_OF_VIEW,
    SEEN_THROUGH,
    UNCLEAR,
    visibility,
)

PLACE = np.array([[4.0, 0.0, 0.25]])
BEAMS = np.radians(np.arange(-10, 11))


@pytest.mark.parametrize(
    ("ranges", "verdict"),
    [(2.0, OCCLUDED), (8.0, SEEN_THROUGH), (3.8, OCCUPIED), (4.3, OCCUPIED), (4.45, UNCLEAR)],
)
def test_a_place_is_judged_by_where_its_beams_end(ranges, verdict):
    ends = ranges * np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    assert visibility(np.zeros(2), ends, np.empty((0, 2)), PLACE).tolist() == [verdict]
    # beams that met nothing say so of what they reach, and nothing of what lies beyond
    passes = SEEN_THROUGH if verdict == SEEN_THROUGH else OUT_OF_VIEW
    assert visibility(np.zeros(2), np.empty((0, 2)), ends, PLACE).tolist() == [passes]


def test_without_a_beam_there_nobody_looked():
    nothing = np.empty((0, 2))
    behind = -8.0 * np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    assert visibility(np.zeros(2), nothing, nothing, PLACE).tolist() == [OUT_OF_VIEW]
    assert visibility(np.zeros(2), behind, nothing, PLACE).tolist() == [OUT_OF_VIEW]
    assert visibility(PLACE[0, :2], behind, nothing, PLACE).tolist() == [UNCLEAR]
    assert len(visibility(np.zeros(2), behind, nothing, np.empty((0, 3)))) == 0
