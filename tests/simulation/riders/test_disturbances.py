"""Disturbed riders: delayed, repeating, trembling, silent, opposed, or with a single switch."""

import numpy as np
import pytest
from scipy.stats import binom
from tests.simulation.riders.rider_views import STEP, acts, pushes, swaying, view

from cohelm.plugins import build

SPOILT = (
    "laggy",
    "noisy",
    "tremor",
    "delayed",
    "dropout",
    "biased",
    "uncooperative",
    "one_switch",
    "reluctant",
)


@pytest.mark.parametrize("name", SPOILT)
def test_one_seed_is_one_hand_and_another_device_none(name):
    views = swaying(200)
    np.testing.assert_array_equal(pushes(name, views, 3), pushes(name, views, 3))
    rider = build("riders", {"use": name, "base": "none"})
    assert rider.act(views[0], None, np.random.default_rng(0)).command is None


@pytest.mark.parametrize("name", [n for n in SPOILT if n not in {"biased", "uncooperative"}])
def test_what_nobody_pushes_nothing_spoils(name):
    assert not pushes({"use": name, "base": "idle"}, swaying(400)).any()


@pytest.mark.parametrize("name", ["tremor", "dropout", "uncooperative", "noisy", "laggy"])
def test_another_seed_is_another_ride(name):
    views = swaying(600)
    assert not np.array_equal(pushes(name, views, 1), pushes(name, views, 2))


def test_a_laggy_hand_stays_where_it_was_eight_times_in_ten():
    views = swaying(3000)
    stays = (np.diff(pushes("laggy", views), axis=0) == 0.0).all(axis=1)
    low, high = binom.interval(0.999, len(stays), 0.8)
    assert low <= stays.sum() <= high
    ideal = pushes("ideal", views)[1:]
    np.testing.assert_array_equal(pushes("laggy", views)[1:][~stays], ideal[~stays])


def test_a_noisy_hand_jerks_on_one_axis_fifteen_times_in_a_hundred():
    views = swaying(3000)
    off = pushes("noisy", views) != pushes("ideal", views)
    assert not off.all(axis=1).any()
    low, high = binom.interval(0.999, len(off), 0.15)
    assert low <= off.any(axis=1).sum() <= high
    low, high = binom.interval(0.999, int(off.sum()), 0.5)
    assert low <= off[:, 0].sum() <= high


@pytest.mark.parametrize("seed", range(8))
def test_a_tremor_is_one_line_in_its_band_and_as_wide_as_drawn(seed):
    """20 pushes a second show what lies below 10 Hz; above, what lies as far below 10 Hz."""
    spec = {"use": "tremor", "amplitude": [0.1, 0.25]}
    views = [view(STEP * k, (0.0, 0.0, 0.0)) for k in range(400)]
    swing = pushes(spec, views, seed) - pushes("ideal", views)
    size = np.hypot(*swing.T)
    assert 0.08 <= size.max() <= 0.25
    assert np.linalg.matrix_rank(swing, tol=1e-9) == 1
    power = (np.abs(np.fft.rfft(swing, axis=0)) ** 2).sum(axis=1)
    at = np.fft.rfftfreq(len(swing), STEP)
    in_band = (at >= 3.0 - 0.1) & (at <= 10.0)
    assert power[in_band].sum() >= 0.95 * power.sum()
    np.testing.assert_allclose(at[np.argmax(power)], at @ power / power.sum(), atol=0.6)


@pytest.mark.parametrize("delay", [0.3, 0.6])
def test_a_late_hand_is_the_good_one_shifted(delay):
    views, late = swaying(200), round(delay / STEP)
    good, done = pushes("ideal", views), pushes({"use": "delayed", "delay": delay}, views)
    np.testing.assert_array_equal(done[late:], good[:-late])
    np.testing.assert_array_equal(done[:late], 0.0)


def test_the_delays_of_two_add_up():
    views = swaying(100)
    twice = {"use": "delayed", "delay": 0.2, "base": {"use": "delayed", "delay": 0.1}}
    np.testing.assert_array_equal(
        pushes(twice, views), pushes({"use": "delayed", "delay": 0.3}, views)
    )


def test_a_silent_device_says_nothing_new():
    views = swaying(4000)
    heard = acts({"use": "dropout", "mean_gap": 5.0, "duration": [0.5, 1.5]}, views)
    age = np.array([v.time - c.heartbeat for v, c in zip(views, heard, strict=True)])
    assert 0.5 < age.max() <= 1.5 + STEP
    begins = np.flatnonzero((age[1:] > 0.0) & (age[:-1] == 0.0))
    # 200 s of a silence of 1 s every 6 s: 33 ± 5.3 (a Poisson's three σ would be 17)
    assert 17 <= len(begins) <= 50
    good = pushes("ideal", views)
    for k in np.flatnonzero(age > 0.0):
        np.testing.assert_array_equal(heard[k].deflection, good[k - round(age[k] / STEP)])


def test_a_biased_rider_steers_by_the_offset_beside_the_way():
    straight = view(0.0, (0.0, 0.0, 0.0))
    left = pushes({"use": "biased", "offset": 0.2}, [straight])[0][1]
    np.testing.assert_allclose(left, 1.2 * 0.2)  # 1.2 of full deflection for each radian
    aligned = view(0.0, (0.0, 0.0, 0.2))
    np.testing.assert_allclose(pushes({"use": "biased", "offset": 0.2}, [aligned])[0][1], 0.0)


def test_an_uncooperative_rider_turns_aside_in_spells_only():
    views = [view(STEP * k) for k in range(4000)]
    spec = {"use": "uncooperative", "mean_gap": 4.0, "duration": [1.0, 1.0], "angle": 1.2}
    push = pushes(spec, views)
    angle = np.round(np.arctan2(push[:, 1], push[:, 0]), 9)
    assert set(angle) == {0.0, 1.2, -1.2}
    share = (angle != 0.0).mean()
    assert 0.1 < share < 0.32  # 1 s in 5 s: 0.2


def one_switch_driven(reaction, views):
    return pushes({"use": "one_switch", "scan_period": 1.0, "reaction_time": reaction}, views)


def test_one_switch_sends_one_of_four_directions_or_stop():
    rng = np.random.default_rng(1)
    turn = np.repeat(rng.uniform(-3.0, 3.0, 50), 100)
    views = [view(STEP * k, (0.0, 0.0, h)) for k, h in enumerate(turn)]
    sent = {tuple(p) for p in pushes("one_switch", views)}
    assert sent <= {(0.0, 0.0), (0.6, 0.0), (-0.6, 0.0), (0.0, 0.4), (0.0, -0.4)}
    assert len(sent) >= 4


@pytest.mark.parametrize(("heading", "lit_at"), [(0.0, 0.0), (-1.5, 1.0), (1.5, 3.0)])
def test_one_switch_waits_until_its_direction_is_lit_and_the_button_pressed(heading, lit_at):
    """Forward lights up first, left after 1 s, back after 2 s, right after 3 s; a press takes
    0.5 s."""
    views = [view(STEP * k, (0.0, 0.0, heading)) for k in range(100)]
    push = one_switch_driven(0.5, views)
    first = np.flatnonzero(push.any(axis=1))[0] * STEP
    np.testing.assert_allclose(first, lit_at + 0.5)
    assert push[-1].any()  # and held


def test_one_switch_lets_go_and_scans_again_when_the_direction_is_no_longer_right():
    """Wants left from 3 s on: lets go at 3.5 s, scans from forward on; left is lit from 4.5 s."""
    views = [view(STEP * k, (0.0, 0.0, 0.0 if k < 60 else -1.5)) for k in range(130)]
    push = one_switch_driven(0.5, views)
    times = STEP * np.arange(len(push))
    stands = times[(~push.any(axis=1)) & (times > 1.0)]
    np.testing.assert_allclose([stands[0], stands[-1]], [3.5, 4.95], atol=1e-6)


def test_a_reluctant_rider_leaves_a_chair_alone_that_goes_their_way():
    views = [view(STEP * k, (0.5 * STEP * k, 0.2, 0.0), speed=0.5) for k in range(200)]
    assert not pushes("reluctant", views).any()


def test_a_reluctant_rider_steers_when_the_chair_goes_astray_and_lets_go_when_it_is_right():
    """It drives across the wanted way from 2 s on for 4 s; one second of that is suffered."""
    heading = [1.2 if 40 <= k < 120 else 0.0 for k in range(200)]
    views = [view(STEP * k, (1.0, 0.0, h), speed=0.5) for k, h in enumerate(heading)]
    push = pushes("reluctant", views)
    steers = STEP * np.flatnonzero(push.any(axis=1))
    np.testing.assert_allclose([steers[0], steers[-1]], [3.0, 5.95], atol=0.051)
    np.testing.assert_array_equal(push[100], pushes("ideal", views[100:101])[0])


def test_a_reluctant_rider_has_patience_with_a_chair_that_stands():
    views = [view(STEP * k) for k in range(200)]
    steers = np.flatnonzero(pushes("reluctant", views).any(axis=1))
    np.testing.assert_allclose(steers[0] * STEP, 5.05)


def test_a_reluctant_rider_minds_their_own_way_not_the_chairs():
    """The chair goes straight on; the rider wants to turn off."""
    views = [
        view(STEP * k, (0.5 * STEP * k, 0.0, 0.0), speed=0.5, goal=np.array([2.0, 5.0]),
             route=np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 5.0]]))
        for k in range(160)
    ]  # fmt: skip
    push = pushes("reluctant", views)
    assert not push[:60].any()
    assert (push[-20:, 1] > 0.5).all()


def test_hands_compose():
    spec = {"use": "tremor", "base": {"use": "delayed", "delay": 0.6}}
    assert not pushes(spec, swaying(12)).any()
    assert pushes(spec, swaying(20))[12:].any()
