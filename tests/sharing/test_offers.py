"""Offers that do not flicker."""

import numpy as np

from cohelm.sharing import EMPTY, OfferParameters, OfferState, update_offers

P = OfferParameters()
FAR = np.full(5, 10.0)


def offers(belief, memory=None, *, time=0.0, cost=FAR):
    return update_offers(time, np.array(belief), cost, memory, P)


def test_the_three_most_probable_places_are_offered():
    shown = offers([0.3, 0.01, 0.25, 0.2, 0.15])
    assert shown.slots == (0, 2, 3)
    assert shown.highlighted == EMPTY


def test_nothing_is_offered_that_is_hardly_believed():
    assert offers([0.04] * 5).slots == (EMPTY,) * 3


def test_a_place_keeps_its_slot_whatever_the_order():
    first = offers([0.3, 0.0, 0.25, 0.2, 0.0])
    assert offers([0.2, 0.0, 0.25, 0.3, 0.0], first, time=60.0) is first


def test_a_slightly_better_place_does_not_displace_another():
    first = offers([0.3, 0.1, 0.25, 0.2, 0.0])
    assert offers([0.3, 0.25, 0.2, 0.2, 0.0], first, time=60.0) is first
    better = offers([0.3, 0.45, 0.15, 0.1, 0.0], first, time=60.0)
    assert better.slots == (0, 2, 1)


def test_an_offer_stays_for_some_seconds():
    first = offers([0.3, 0.0, 0.25, 0.2, 0.0])
    moved = [0.3, 0.45, 0.03, 0.2, 0.0]
    assert offers(moved, first, time=P.shown_time - 0.1).slots == (0, 2, 3)
    assert 1 in offers(moved, first, time=P.shown_time).slots


def test_one_place_is_highlighted_above_nine_tenths_and_with_hysteresis():
    sure = offers([0.95, 0.01, 0.01, 0.01, 0.01])
    assert sure.highlighted == 0
    assert offers([0.89, 0.05, 0.05, 0.0, 0.0]).highlighted == EMPTY
    assert offers([0.8, 0.1, 0.05, 0.0, 0.0], sure).highlighted == 0
    assert offers([0.7, 0.2, 0.05, 0.0, 0.0], sure).highlighted == EMPTY


def test_a_place_that_was_reached_is_offered_no_longer():
    first = offers([0.95, 0.0, 0.0, 0.0, 0.0])
    there = FAR.copy()
    there[0] = 1.0
    assert offers([0.95, 0.0, 0.0, 0.0, 0.0], first, cost=there) == OfferState(
        slots=(EMPTY,) * 3, since=first.since
    )


def test_a_map_without_places_has_no_offers():
    assert offers([], cost=np.empty(0)) == OfferState()
