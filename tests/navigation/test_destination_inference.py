"""Laws of destination inference, on a room with five places."""

import itertools
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.maps import NamedPlace, Places
from cohelm.messages import Mode, OfferReason
from cohelm.navigation import DestinationParameters
from cohelm.navigation.destination_inference import destination_inference
from cohelm.testing.scenes import room

from .scenes import navigator, observation, request, ride

AT = {
    "North-east": (10.53, 6.53),
    "South-east": (10.53, 1.53),
    "North": (6.03, 6.53),
    "South": (6.03, 1.53),
    "West": (1.03, 4.03),
}
TURN_RATE, TICK = 1.2, 0.05
NOWHERE = np.full(2, np.nan)


def inference(at=AT, **changes):
    places = Places(places=tuple(NamedPlace(name=name, point=p) for name, p in at.items()))
    parameters = DestinationParameters.model_validate(changes)
    return destination_inference(room(), (), places, 0.3, parameters)


ROOM = inference()


def driven(poses, sticks, model=ROOM):
    """(belief of each step, last memory)."""
    beliefs, memory = [], None
    for k, (pose, stick) in enumerate(zip(poses, sticks, strict=True)):
        found, memory = model.update(
            k * TICK, np.array(pose), np.array(stick, dtype=float), TURN_RATE, memory
        )
        beliefs.append(found)
    return beliefs, memory


def straight(a, b, speed=0.8):
    """Poses and sticks from a to b."""
    way = np.subtract(b, a)
    count = int(np.hypot(*way) / (speed * TICK))
    heading = np.arctan2(way[1], way[0])
    poses = [(*(np.array(a) + way * k / count), heading) for k in range(count + 1)]
    return poses, [(0.7, 0.0)] * len(poses)


walks = st.lists(
    st.tuples(st.floats(0.6, 11.4), st.floats(0.6, 7.4), st.floats(-3.1, 3.1)),
    min_size=1,
    max_size=12,
)
sticks = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))


@given(walks, sticks)
@settings(max_examples=40, deadline=None)
def test_probabilities_sum_to_one(walk, stick):
    beliefs, _ = driven(walk, [stick] * len(walk))
    for each in beliefs:
        assert each.places.sum() + each.elsewhere == pytest.approx(1.0)
        assert (each.places >= 0.0).all()
        assert each.elsewhere > 0.0
        assert len(each.offers) <= 3
        assert sum(offer.highlighted for offer in each.offers) <= 1


@given(walks, sticks, st.permutations(range(len(AT))))
@settings(max_examples=20, deadline=None)
def test_other_order_of_the_places_other_order_of_the_belief(walk, stick, order):
    names = list(AT)
    other = inference({names[k]: AT[names[k]] for k in order})
    here, _ = driven(walk, [stick] * len(walk))
    there, _ = driven(walk, [stick] * len(walk), other)
    for a, b in zip(here, there, strict=True):
        assert np.allclose(a.places[list(order)], b.places)
        assert a.elsewhere == pytest.approx(b.elsewhere)


def test_in_a_mirror_everything_is_mirrored():
    other = inference({name: (x, 8.0 - y) for name, (x, y) in AT.items()})
    poses, _ = straight((1.0, 4.5), (9.0, 6.0))
    pushed = [(0.7, 0.2)] * len(poses)
    here, _ = driven(poses, pushed)
    mirrored = [(x, 8.0 - y, -heading) for x, y, heading in poses]
    there, _ = driven(mirrored, [(0.7, -0.2)] * len(poses), other)
    for a, b in zip(here, there, strict=True):
        assert np.allclose(a.places, b.places, atol=1e-6)
        assert [offer.name for offer in a.offers] == [offer.name for offer in b.offers]


def test_a_chair_that_stands_with_a_released_stick_changes_nothing():
    poses, pushed = straight((2.0, 4.0), (5.0, 4.9))
    before, memory = driven(poses, pushed)
    for k in range(200):
        later, after = ROOM.update(10.0 + k, np.array(poses[-1]), np.zeros(2), TURN_RATE, memory)
        assert after is memory
        assert identical(later, before[-1])


@pytest.mark.parametrize("name", list(AT))
def test_who_drives_straight_to_a_place_is_believed_to_go_there(name):
    start = (6.0, 4.0) if name != "West" else (10.0, 4.0)
    beliefs, _ = driven(*straight(start, AT[name]))
    at = list(AT).index(name)
    assert beliefs[-1].places[at] > beliefs[0].places[at]
    assert np.argmax(beliefs[len(beliefs) // 2].places) == at
    assert all(b.places[at] >= a.places[at] - 0.02 for a, b in itertools.pairwise(beliefs))


def test_the_stick_alone_speaks_for_where_it_leads():
    still = [(6.0, 4.0, 0.6)] * 60
    pushed, _ = driven(still, [(0.3, 0.1)] * 60)
    assert pushed[-1].places[0] > 1.5 * pushed[0].places[0]
    assert pushed[-1].places[3] < pushed[0].places[3]


def test_old_evidence_is_forgotten():
    there, back = straight((3.0, 4.0), (9.0, 6.5)), straight((9.0, 6.5), (2.0, 4.2))
    beliefs, _ = driven(there[0] + back[0], there[1] + back[1])
    assert np.argmax(beliefs[len(there[0])].places) == list(AT).index("North-east")
    assert np.argmax(beliefs[-1].places) == list(AT).index("West")


def test_habits_are_the_prior_and_are_given_as_the_reason():
    model = inference(inference={"habits": {"South": 30, "Unknown": 5}})
    belief, _ = model.update(0.0, np.array([3.0, 4.0, 0.0]), np.zeros(2), TURN_RATE, None)
    assert np.argmax(belief.places) == 3
    south = next(offer for offer in belief.offers if offer.name == "South")
    assert south.reason is OfferReason.HABIT


def test_an_offer_says_why_it_is_believed():
    beliefs, _ = driven(*straight((2.0, 4.5), (8.0, 5.8)))
    best = max(beliefs[-1].offers, key=lambda offer: offer.belief)
    assert best.name == "North-east"
    assert best.reason is OfferReason.CLOSER_AND_STEERING
    assert best.sentence == f"{best.progress:.0f} m closer, and you steer towards it"
    assert 3.0 < best.progress < 6.5


def test_an_unreachable_place_is_never_believed():
    places = Places(
        places=(
            NamedPlace(name="Here", point=(3.0, 4.0)),
            NamedPlace(name="There", point=(10.0, 4.0)),
        )
    )
    shut = room(boxes=[(5.9, 0.0, 6.1, 8.0)])
    model = destination_inference(shut, (), places, 0.3, DestinationParameters())
    belief, _ = model.update(0.0, np.array([2.0, 2.0, 0.0]), np.ones(2), TURN_RATE, None)
    assert belief.places[1] == 0.0
    assert belief.places[0] > 0.0


def test_without_places_or_wish_to_infer_there_is_nothing():
    assert inference({}) is None
    assert inference(infer=False) is None


# ------------------------------------------------------------------ in the navigator


@pytest.fixture(scope="module")
def chair():
    return navigator(
        places=Places(places=tuple(NamedPlace(name=n, point=p) for n, p in AT.items()))
    )


def test_the_navigator_offers_and_never_chooses(chair):
    asked = request(Mode.ASSISTED, NOWHERE)
    ticks = ride(chair, 160, stick=lambda k: (0.8, 0.02), asked=lambda k: asked)
    assert any(tick.destinations.offers for tick in ticks)
    assert all(np.isnan(tick.request.goal).all() for tick in ticks)
    assert all(tick.path is None and not tick.arrived for tick in ticks)


def test_the_memory_is_a_value(chair):
    asked = request(Mode.ASSISTED, NOWHERE)
    ticks = ride(chair, 40, stick=lambda k: (0.8, 0.1), asked=lambda k: asked)
    last = replace(ticks[-2], memory=pickle.loads(pickle.dumps(ticks[-2].memory)))
    again = chair.step(ticks[-1].observation, asked, last)
    assert identical(again.memory.destinations, ticks[-1].memory.destinations)
    assert identical(again.destinations, ticks[-1].destinations)


def test_a_chosen_destination_ends_the_inference(chair):
    free = chair.step(observation(), request(Mode.SHARED, NOWHERE), None)
    assert free.destinations is not None
    chosen = chair.step(observation(1), request(Mode.SHARED), free)
    assert chosen.destinations is None
    assert chosen.memory.destinations is None


def test_it_does_not_move_the_chair_otherwise():
    asked = request(Mode.ASSISTED, NOWHERE)
    with_places = navigator(places=Places(places=(NamedPlace(name="A", point=(9.0, 4.0)),)))
    for a, b in zip(
        *(
            ride(each, 30, stick=lambda k: (0.7, 0.1), asked=lambda k: asked)
            for each in (with_places, navigator())
        ),
        strict=True,
    ):
        assert identical(a.decision, b.decision)
