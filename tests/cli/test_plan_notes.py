"""What ``cohelm plan`` says beside figures: closed starts, wishes off the map or not served."""

import json
import re

import numpy as np
import pytest

from .conftest import mask

ENDS = ("--start=-4,-1", "--goal=4,-1")


@pytest.fixture
def planned(cohelm, room):
    """What the JSON of a plan across the room says."""

    def _planned(*options):
        code, out, err = cohelm("plan", room, *ENDS, *options, "--json")
        assert (code, err) == (0, "")
        return json.loads(out)

    return _planned


def test_there_is_nothing_to_note_where_all_is_well(planned):
    assert planned("--prefer=0,1", "--avoid-hard", "3,2,0.3")["notes"] == []


def test_a_start_in_a_zone_never_to_enter_is_told(planned):
    (note,) = planned("--avoid-hard", "3,2,0.3", "--avoid-hard=-4,-1,0.5")["notes"]
    assert "the start lies inside zone 2, never to enter" in note


def test_a_start_in_a_keepout_zone_is_told(planned, tmp_path):
    pixels = np.full((60, 100), 254, dtype=np.uint8)
    pixels[:, :20] = 0
    (note,) = planned("--keepout", mask(tmp_path, "keepout", pixels))["notes"]
    assert "the start lies inside a keepout zone" in note


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ("--prefer=33,7", "point 1 (33, 7) lies off the map"),
        ("--prefer=0,9", "point 1 (0, 9) lies off the map"),
        ("--avoid=33,7,1", "zone 1 lies off the map"),
    ],
)
def test_what_lies_off_the_map_is_told(planned, option, says):
    assert planned(option)["notes"] == [says]


def test_a_point_that_is_passed_by_is_told_with_what_it_would_cost(planned):
    # There and back again is 2.5 m each way, a little dearer than λ = 1 pays for.
    near = planned("--prefer=0,1.5", "--method", "astar")
    (note,) = near["notes"]
    found = re.fullmatch(
        r"with --method soft_via the route comes to (\S+) m of point 1, (\S+) m longer", note
    )
    there = planned("--prefer=0,1.5")
    assert float(found[1]) == pytest.approx(there["closest_to_each"][0], abs=0.006)
    assert float(found[2]) == pytest.approx(there["length"] - near["length"], abs=0.06)


def test_the_closeness_that_is_named_is_enough(planned):
    ordered = ("--prefer=3,1", "--prefer=-3,1", "--ordered", "--set", "closeness=0.2")
    missed = planned(*ordered)
    assert max(missed["closest_to_each"]) > 1.0
    (note,) = missed["notes"]
    option = re.match(r"with --set (closeness=\d+) the route comes to", note)[1]
    assert max(planned(*ordered[:-1], option)["closest_to_each"]) < 1.0


def test_a_clearance_is_kept_or_told(planned):
    report = planned("--clearance", "0.5", "--prefer=0,2.2")
    kept = report["minimum_clearance"] >= 0.5 - 0.005
    assert any("is not kept" in note for note in report["notes"]) != kept


def test_a_hard_zone_is_measured_from_the_outline_of_the_chair(cohelm, planned, room):
    zone = ("--avoid-hard", "0,-1,0.3")
    report = planned(*zone)
    assert 0.0 < report["gaps_to_zones"][0] < report["closest_to_zones"][0]
    out = cohelm("plan", room, *ENDS, *zone)[1]
    assert f"kept {report['gaps_to_zones'][0]:.2f} m from the chair's footprint" in out
