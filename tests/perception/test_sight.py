import numpy as np
import pytest

from cohelm.perception.sight import FILLED, HIDDEN, SEEN_THROUGH, UNCLEAR, UNLOOKED, sight

PLACE = np.array([[4.0, 0.0, 0.25]])
BEAMS = np.radians(np.arange(-10, 11))


@pytest.mark.parametrize(
    ("ranges", "verdict"),
    [(2.0, HIDDEN), (8.0, SEEN_THROUGH), (3.8, FILLED), (4.3, FILLED), (4.45, UNCLEAR)],
)
def test_a_place_is_judged_by_where_its_beams_end(ranges, verdict):
    ends = ranges * np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    assert sight(np.zeros(2), ends, np.empty((0, 2)), PLACE).tolist() == [verdict]
    # beams that met nothing say so of what they reach, and nothing of what lies beyond
    passes = SEEN_THROUGH if verdict == SEEN_THROUGH else UNLOOKED
    assert sight(np.zeros(2), np.empty((0, 2)), ends, PLACE).tolist() == [passes]


def test_without_a_beam_there_nobody_looked():
    nothing = np.empty((0, 2))
    behind = -8.0 * np.stack([np.cos(BEAMS), np.sin(BEAMS)], axis=-1)
    assert sight(np.zeros(2), nothing, nothing, PLACE).tolist() == [UNLOOKED]
    assert sight(np.zeros(2), behind, nothing, PLACE).tolist() == [UNLOOKED]
    assert sight(PLACE[0, :2], behind, nothing, PLACE).tolist() == [UNCLEAR]
    assert len(sight(np.zeros(2), behind, nothing, np.empty((0, 3)))) == 0
