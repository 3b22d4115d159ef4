"""Doors that are found in plain maps against doors marked by eye in ten places of them."""

import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.buildings import read_building

MAPS = Path(os.environ.get("COHELM_DATA", "")) / "ros_maps"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not MAPS.is_dir(), reason="COHELM_DATA has no ros_maps"),
    pytest.mark.filterwarnings("ignore::cohelm.maps.MapWarning"),
]
NEAR = 0.6
"""Distance of a door that is found from the one that was marked, m."""
MARKED = [
    ("utexas_gdc_3ne", (-50, -9, -28, 3.2), [(-40.3, -3.45), (-38.45, -5.2), (-28.75, -3.85)]),
    (
        "utexas_gdc_3ne", (-28, -9, -4, 3.2),
        [(-22.3, -3.95), (-21.05, -3.9), (-9.5, -4.05), (-20.15, -5.6)],
    ),
    ("utexas_gdc_3ne", (-57, -20, -33, -10.5), [(-39.05, -10.7), (-45.85, -12.25), (-44.7, -12.3)]),
    (
        "utexas_gdc_3ne", (-33, -20, -8, -10.5),
        [(-30.1, -12.6), (-28.9, -12.65), (-22.4, -12.8), (-21.2, -12.85), (-20.6, -11.1)],
    ),
    (
        "utexas_gdc_1n", (-38, -9, -8, 2),
        [(-36.4, -4), (-30.25, -4), (-28.75, -4), (-22.35, -4), (-21.25, -4), (-17.25, -4),
         (-10, -4), (-25.1, -6.1)],
    ),
    (
        "aws_hospital_sim", (-14, 9, 12, 20.2),
        [(-6.35, 14), (4.05, 14), (-7.8, 11), (5.55, 11), (-10.1, 10.2), (7.8, 10.2)],
    ),
    (
        "aws_hospital_sim", (-14, -20, 12, -8),
        [(-7.6, -10.05), (5.35, -10.1), (-3.95, -11), (1.7, -11.05), (-3.95, -17), (1.7, -17)],
    ),
    (
        "aws_hospital_sim", (-14, -36.5, 12, -22),
        [(-7.55, -24.1), (-7.55, -26), (5.3, -24.2), (4.2, -27.1), (-8.5, -33), (-3.65, -33.1)],
    ),
    ("intel_lab", (0, 30, 26, 58.1), [(7.3, 48.5), (19, 48.6), (6, 42.5)]),
    ("intel_lab", (32, 0, 58, 26), [(48.6, 18.5), (48.4, 6.7)]),
]  # fmt: skip
"""Map, box (x0, y0, x1, y1) and middles of its doors; map frame, m."""


def test_doors_of_plain_maps_agree_with_those_marked_by_eye():
    storeys, right, found, marked = {}, 0, 0, 0
    for name, (x0, y0, x1, y1), doors in MARKED:
        if name not in storeys:
            storeys[name] = read_building(MAPS / f"{name}.yaml")[0]
        points = np.array([door.point for door in storeys[name].doors])
        points = points[((points >= (x0, y0)) & (points <= (x1, y1))).all(axis=1)]
        distances = np.hypot(*(points[:, None] - np.array(doors)[None]).transpose(2, 0, 1))
        right += int((distances.min(axis=0) < NEAR).sum())
        found, marked = found + len(points), marked + len(doors)
    figures = f"precision {right / found:.2f}, recall {right / marked:.2f} of {marked} doors"
    assert right / found >= 0.55, figures
    assert right / marked >= 0.78, figures
