import numpy as np
import pytest

from cohelm.perception.tracking.association import Visibility, visibility

PLACE = np.array([[4.0, 0.0, 0.25]])
BEAMS = np.radians(np.arange(-10, 11))


@pytest.mark.parametrize(
    ("ranges", "verdict"),
    [
        (2.0, Visibility.OCCLUDED),
        (8.0, Visibility.SEEN_THROUGH),
        (3.8, Visibility.OCCUPIED),
        (4.3, Visibility.OCCUPIED),
        (4.45, Visibility.UNCLEAR),
    ],
)
def test_a_place_is_judged_by_where_its_beams_end(ranges, verdict):
    ends = ranges * np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    assert visibility(np.zeros(2), ends, np.empty((0, 2)), PLACE).tolist() == [verdict]
    # beams that met nothing say so of what they reach, and nothing of what lies beyond
    passes = (
        Visibility.SEEN_THROUGH if verdict == Visibility.SEEN_THROUGH else Visibility.OUT_OF_VIEW
    )
    assert visibility(np.zeros(2), np.empty((0, 2)), ends, PLACE).tolist() == [passes]


def test_without_a_beam_there_nobody_looked():
    nothing = np.empty((0, 2))
    behind = -8.0 * np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    assert visibility(np.zeros(2), nothing, nothing, PLACE).tolist() == [Visibility.OUT_OF_VIEW]
    assert visibility(np.zeros(2), behind, nothing, PLACE).tolist() == [Visibility.OUT_OF_VIEW]
    assert visibility(PLACE[0, :2], behind, nothing, PLACE).tolist() == [Visibility.UNCLEAR]
    assert len(visibility(np.zeros(2), behind, nothing, np.empty((0, 3)))) == 0
