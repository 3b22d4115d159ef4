"""Outlines of standing groups."""

import numpy as np

from cohelm.messages import Groups
from cohelm.navigation.group_outlines import group_outlines
from cohelm.testing.scenes import walkers

STANDING = 0.3


def square(*others):
    return walkers(
        [
            [x, y, 0.0, 0.0]
            for x, y in [(1e5, 0.0), (1e5 + 1, 0.0), (1e5 + 1, 1.0), (1e5, 1.0), (1e5 + 0.5, 0.5)]
        ]
        + list(others)
    )


def test_four_about_a_fifth_make_a_square():
    people = square()
    (hull,) = group_outlines(people, Groups(id=[7], member=[0] * 5), STANDING)
    assert sorted(map(tuple, hull.tolist())) == sorted(map(tuple, people.mean[:4, :2].tolist()))
    # in order round the outline: its area by the shoelace formula is 1 m², whichever way round
    x, y = (hull - hull.mean(axis=0)).T
    assert abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2.0 == 1.0


def test_two_make_a_segment_and_so_do_three_in_line():
    two = walkers([[0.0, 0.0, 0.0, 0.0], [1.0, 2.0, 0.1, 0.0], [5.0, 5.0, 0.0, 0.0]])
    (segment,) = group_outlines(two, Groups(id=[1], member=[0, 0, -1]), STANDING)
    assert sorted(segment.tolist()) == [[0.0, 0.0], [1.0, 2.0]]
    line = walkers([[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [2.0, 2.0, 0.0, 0.0]])
    (segment,) = group_outlines(line, Groups(id=[1], member=[0, 0, 0]), STANDING)
    assert {tuple(p) for p in segment.tolist()} >= {(0.0, 0.0), (2.0, 2.0)}


def test_who_walks_or_is_alone_is_no_part_of_it():
    people = walkers([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.5, 1.0, 0.9, 0.0]])
    (segment,) = group_outlines(people, Groups(id=[3], member=[0, 0, 0]), STANDING)
    assert len(segment) == 2
    walking = walkers([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0]])
    assert group_outlines(walking, Groups(id=[3], member=[0, 0]), STANDING) == ()
    assert group_outlines(people, Groups.alone(3), STANDING) == ()
    assert group_outlines(walkers([]), Groups.alone(0), STANDING) == ()
