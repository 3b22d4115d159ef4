from dataclasses import replace

import numpy as np
import pytest
from tests.perception.formations import (
    abreast,
    back_to_back,
    circle,
    corner,
    face_to_face,
    people,
    queue,
    strangers,
    watch,
)

from cohelm.arrays import identical
from cohelm.messages import People
from cohelm.perception import Affinity
from cohelm.perception.groups.affinity import cluster_people, inherit_ids
from cohelm.testing import check_group_detector

TRIES = 40


def share(make, seed=0, *, whole=True, known=True):
    """Of the scenes made: in how many all (or any) are in one group after four seconds."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(TRIES):
        place, heading = make(rng)
        member = watch(place, heading if known else np.nan, rng=rng)[-1]
        together = member[0] >= 0 and (member == member[0]).all()
        found.append(together if whole else (member >= 0).any())
    return np.mean(found)


def test_keeps_the_contract():
    check_group_detector(Affinity())


@pytest.mark.parametrize("make", [*map(circle, (2, 3, 4, 5)), face_to_face, corner, abreast])
def test_nine_in_ten_who_share_an_o_space_are_found(make):
    assert share(make) >= 0.9


@pytest.mark.parametrize("make", [queue, back_to_back, strangers])
def test_at_most_one_in_ten_who_share_none_are_taken_for_a_group(make):
    assert share(make, whole=False) <= 0.1


def test_with_unknown_headings_nearness_alone_decides_and_is_less_sure():
    assert share(circle(3), known=False) >= 0.8
    assert share(strangers, whole=False, known=False) <= 0.1
    # the same pair, heading known and not: the log-odds are lower where it is not
    detector = Affinity()
    place = [[0.0, 0.0], [1.0, 0.0]]
    sure, unsure = (
        detector.group(people(0.0, place, heading), None)[1].log_odds[0, 1]
        for heading in ([0.0, np.pi], [np.nan, np.pi])
    )
    assert sure > unsure > 0.0


@pytest.mark.parametrize("gap", [0.6, 0.9, 1.2])
def test_who_only_passes_is_never_in_a_group(gap):
    rng = np.random.default_rng(1)
    for speed in (1.4, 1.6):
        passing = watch([[0, 0], [-3, gap]], 0.0, [[0, 0], [speed, 0]], rng=rng, duration=6.0)
        assert (passing < 0).all()
        meeting = watch(
            [[-4, 0], [4, gap]], [0.0, np.pi], [[speed, 0], [-speed, 0]], rng=rng, duration=6.0
        )
        assert (meeting < 0).all()
        overtaking = watch(
            [[0, 0], [-3, gap]], 0.0, [[1.0, 0], [1.0 + speed / 2, 0]], rng=rng, duration=10.0
        )
        assert (overtaking < 0).all()


def test_companions_are_found_within_two_seconds_and_stay_together():
    rng = np.random.default_rng(2)
    for side in (0.5, 0.8, 1.1):
        member = watch([[0, 0], [0, side]], 0.0, [[1.2, 0], [1.2, 0]], rng=rng, duration=10.0)
        assert (member[20:] == 0).all()


def test_companions_who_stop_and_go_on_keep_their_id():
    detector, memory, ids = Affinity(), None, []
    x = 0.0
    for k in range(200):
        speed = 0.0 if 80 <= k < 140 else 1.2
        x += 0.1 * speed
        seen = people(0.1 * k, [[x, 0.0], [x, 0.7]], 0.0, [speed, 0.0])
        groups, memory = detector.group(seen, memory)
        ids.append(tuple(groups.id))
    assert set(ids[20:]) == {(0,)}


def test_the_order_of_people_and_the_place_of_the_world_do_not_matter():
    rng = np.random.default_rng(3)
    place, velocity = rng.uniform(-3, 3, (12, 2)), rng.normal(0, 0.7, (12, 2))
    order = rng.permutation(12)
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    detector, memories = Affinity(), [None, None, None]
    for k in range(30):
        here = place + 0.1 * k * velocity
        course = np.arctan2(velocity[:, 1], velocity[:, 0])
        one = people(0.1 * k, here, course, velocity)
        other = People(
            time=one.time,
            **{
                name: getattr(one, name)[order]
                for name in ("id", "mean", "covariance", "heading", "radius", "confidence")
            },
        )
        turned = people(0.1 * k, here @ turn + 5.0, course + np.arctan2(0.8, 0.6), velocity @ turn)
        said = []
        for which, seen in enumerate((one, other, turned)):
            groups, memories[which] = detector.group(seen, memories[which])
            said.append(groups)
        assert identical(said[0].id, said[1].id)
        assert identical(said[0].member[order], said[1].member)
        assert identical(said[0], said[2])


def test_who_comes_back_soon_is_still_of_the_group():
    detector, memory = Affinity(), None
    both = np.array([[0.0, 0.0], [0.0, 0.7]])
    for k in range(60):
        shift = np.array([0.12 * k, 0.0])
        everyone = people(0.1 * k, both + shift, 0.0, [1.2, 0.0])
        alone = replace(
            everyone,
            **{
                name: getattr(everyone, name)[:1]
                for name in ("id", "mean", "covariance", "heading", "radius", "confidence")
            },
        )
        hidden = 30 <= k < 45
        groups, memory = detector.group(alone if hidden else everyone, memory)
        if hidden:
            assert len(groups.id) == 0
        elif k >= 20:
            assert groups.id.tolist() == [0]


def test_a_clock_that_stands_adds_nothing_and_one_that_runs_back_starts_anew():
    detector = Affinity()
    seen = people(5.0, [[0, 0], [0, 0.8]], 0.0, [1.2, 0.0])
    _, memory = detector.group(seen, None)
    _, again = detector.group(seen, memory)
    assert identical(memory.log_odds, again.log_odds)
    _, earlier = detector.group(replace(seen, time=1.0), again)
    assert earlier.time == 1.0
    assert earlier.next_id >= again.next_id
    assert identical(earlier.log_odds, memory.log_odds)


# --- joining and ids -------------------------------------------------------------------------


def test_joins_by_the_mean_over_all_pairs_and_the_strongest():
    # 0-1 and 1-2 speak for it by 2, 0-2 against it by 1: the mean to the third is 1/2 > 0
    evidence = np.array([[0.0, 2.0, -1.0], [2.0, 0.0, 2.0], [-1.0, 2.0, 0.0]])
    assert cluster_people(evidence, 0.0).tolist() == [0, 0, 0]
    # against it by 3: the mean is −1/2
    evidence[0, 2] = evidence[2, 0] = -3.0
    assert cluster_people(evidence, 0.0).tolist() == [0, 0, 2]
    # a quarter of the strongest: 3/4 · (−1/2) + 1/4 · 2 = 1/8
    assert cluster_people(evidence, 0.25).tolist() == [0, 0, 0]
    assert cluster_people(np.zeros((4, 4)), 0.5).tolist() == [0, 1, 2, 3]
    assert cluster_people(np.zeros((0, 0)), 0.5).tolist() == []


def inherited(label, before, next_id=10):
    group, free = inherit_ids(np.array(label, dtype=int), np.array(before, dtype=int), next_id)
    return group.tolist(), free


def test_the_larger_part_keeps_the_id():
    # split in three and two
    assert inherited([0, 0, 0, 3, 3], [7] * 5) == ([7, 7, 7, 10, 10], 11)
    # merge of three and two
    assert inherited([0] * 5, [4, 4, 7, 7, 7]) == ([7] * 5, 10)
    # of equals the older id
    assert inherited([0] * 4, [7, 7, 4, 4]) == ([4] * 4, 10)
    # two swap partners: nobody's id is given twice
    group, free = inherited([0, 1, 0, 1], [4, 4, 7, 7])
    assert sorted(set(group)) == [4, 7]
    assert free == 10
    # alone again: no id; new ones are never old
    assert inherited([0, 1, 2, 2], [4, 4, -1, -1]) == ([-1, -1, 10, 10], 11)
    assert inherited([], []) == ([], 10)
