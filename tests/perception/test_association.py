"""Which sighting is whose; the numbers are worked out by hand."""

import math

import numpy as np
import pytest

from cohelm.perception.tracking.association import (
    NO_MATCH,
    Gates,
    associate,
    measured_positions,
    merged_partners,
)


def tracks(*places):
    """Of people at rest in these places: means (m, 4)."""
    return np.array([(x, y, 0.0, 0.0) for x, y in places])


def matched(means, positions, *, confirmed=None, gate=9.0, max_cost=100.0, reach=5.0):
    """With P = 0.09 I of each place and σ = 0.4 m of each sighting, so that S = 0.25 I."""
    m, d = len(means), len(positions)
    return associate(
        means,
        np.tile(np.diag([0.09, 0.09, 1.0, 1.0]), (m, 1, 1)),
        np.ones(m, dtype=bool) if confirmed is None else np.array(confirmed),
        np.array(positions, dtype=float).reshape(d, 2),
        np.full(d, 0.4),
        Gates(gate, max_cost, reach),
    )


def test_the_sum_of_all_distances_is_least_not_each_of_them():
    # alone, each would take the sighting at 0; the sum of squares is 0.5² + 0.5² against 0 + 1²
    match, squared = matched(tracks((0.0, 0.0), (-0.5, 0.0)), [(0.5, 0.0), (0.0, 0.0)])
    assert match.tolist() == [0, 1]
    assert squared == pytest.approx([1.0, 1.0])  # 0.5² / 0.25


@pytest.mark.parametrize(("away", "found"), [(1.49, [0]), (1.51, [NO_MATCH])])
def test_the_gate(away, found):
    # away² / 0.25 ≤ 9 up to 1.5 m; half the reach is 1 m, so that nothing is found beyond the gate
    match, squared = matched(tracks((0.0, 0.0)), [(away, 0.0)], reach=2.0)
    assert match.tolist() == found
    assert squared == pytest.approx([away**2 / 0.25 if found == [0] else 0.0])


def test_a_confirmed_track_may_take_what_is_left_within_half_its_reach():
    assert matched(tracks((0.0, 0.0)), [(1.6, 0.0)], reach=4.0)[0].tolist() == [0]
    assert matched(tracks((0.0, 0.0)), [(1.6, 0.0)], reach=3.0)[0].tolist() == [NO_MATCH]
    tentative = matched(tracks((0.0, 0.0)), [(1.6, 0.0)], reach=4.0, confirmed=[False])
    assert tentative[0].tolist() == [NO_MATCH]


def test_beyond_the_largest_cost_a_sighting_is_rather_a_strangers():
    # 0.5 m off: 1 + ln det S = 1 + 2 ln 0.25 = −1.77
    cost = 1.0 + 2.0 * math.log(0.25)
    for max_cost, found in ((cost + 0.01, [0]), (cost - 0.01, [NO_MATCH])):
        got = matched(tracks((0.0, 0.0)), [(0.5, 0.0)], max_cost=max_cost, reach=0.9)
        assert got[0].tolist() == found


def test_a_tentative_track_yields_to_a_confirmed_one_that_is_a_little_farther():
    # 3 on top: 0.25 / 0.25 + 3 against 0.64 / 0.25 = 2.56
    means = tracks((-0.5, 0.0), (0.8, 0.0))
    match, _ = matched(means, [(0.0, 0.0)], confirmed=[False, True])
    assert match.tolist() == [NO_MATCH, 0]


def test_an_object_shares_no_cluster_with_a_person():
    means = tracks((-0.3, 0.0), (0.3, 0.0))
    given = company(means, [NO_MATCH, 0], [(0.02, 0.0)], confirmed=(True, False))
    assert given == [NO_MATCH, NO_MATCH]


def test_nobody_and_nothing():
    assert matched(np.empty((0, 4)), [(0.0, 0.0)])[0].tolist() == []
    assert matched(tracks((0.0, 0.0)), [])[0].tolist() == [NO_MATCH]


def company(
    means, match, position, *, near=0.3, missing=(True, False), confirmed=(True, True), radius=0.4
):
    return merged_partners(
        means,
        np.array(missing),
        np.array(confirmed),
        np.array(match),
        np.array(position, dtype=float).reshape(-1, 2),
        np.full(len(position), radius),
        near,
    ).tolist()


def test_two_are_one_where_the_cluster_lies_between_them():
    # expected at ±0.3 m, seen at 0.02 m: 0.02 to the middle, 0.28 and 0.32 to them
    means = tracks((-0.3, 0.0), (0.3, 0.0))
    assert company(means, [NO_MATCH, 0], [(0.02, 0.0)]) == [1, NO_MATCH]


def test_the_other_is_hidden_where_the_cluster_lies_on_one_of_them():
    # seen at 0.2 m: 0.2 to the middle, 0.1 to the one it was given to
    means = tracks((-0.3, 0.0), (0.3, 0.0))
    assert company(means, [NO_MATCH, 0], [(0.2, 0.0)]) == [NO_MATCH, NO_MATCH]


@pytest.mark.parametrize(("half", "found"), [(0.69, [1, NO_MATCH]), (0.71, [NO_MATCH, NO_MATCH])])
def test_they_are_one_up_to_so_far_beyond_the_clusters_radius(half, found):
    # radius 0.4 and 0.3 beyond: up to 0.7 m from the middle of the cluster
    assert company(tracks((-half, 0.0), (half, 0.0)), [NO_MATCH, 0], [(0.0, 0.0)]) == found


def test_whoever_was_found_or_is_nobody_yet_looks_for_no_company():
    means = tracks((-0.3, 0.0), (0.3, 0.0))
    assert company(means, [NO_MATCH, 0], [(0.0, 0.0)], missing=(False, False)) == [
        NO_MATCH,
        NO_MATCH,
    ]


def test_one_cluster_is_two_people_at_most():
    means = tracks((-0.3, 0.0), (0.3, 0.0), (-0.3, 0.05))
    got = company(means, [NO_MATCH, 0, NO_MATCH], [(0.0, 0.0)], missing=(True, False, True))
    assert got == [1, NO_MATCH, NO_MATCH]


def test_one_alone_is_corrected_by_its_own_sighting():
    who, place, deviation = measured_positions(
        tracks((0.0, 0.0), (5.0, 0.0)),
        np.array([1, NO_MATCH]),
        np.array([NO_MATCH, NO_MATCH]),
        np.array([[9.0, 9.0], [0.1, 0.2]]),
        np.array([0.7, 0.05]),
    )
    assert who.tolist() == [0]
    assert place.tolist() == [[0.1, 0.2]]
    assert deviation.tolist() == [0.05]


def test_of_two_the_middle_is_measured_and_each_less_surely_by_half_their_distance():
    # 0.6 m apart, the middle seen at (0.1, 0.0) with 0.4 m: ±0.3 m about it, √(0.3² + 0.4²) = 0.5
    who, place, deviation = measured_positions(
        tracks((-0.3, 0.0), (0.3, 0.0)),
        np.array([NO_MATCH, 0]),
        np.array([1, NO_MATCH]),
        np.array([[0.1, 0.0]]),
        np.array([0.4]),
    )
    assert who.tolist() == [0, 1]
    assert place == pytest.approx(np.array([[-0.2, 0.0], [0.4, 0.0]]))
    assert deviation == pytest.approx([0.5, 0.5])
