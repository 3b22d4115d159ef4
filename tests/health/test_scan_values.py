"""A sweep by itself: no reading, one value for many beams, the sweep before to the last bit."""

import numpy as np
import pytest

from cohelm.health.sweeps import check_sweep

RNG = np.random.default_rng(0)
SOUND = 3.0 + 0.01 * RNG.standard_normal(360)


def test_a_sound_sweep_is_usable_also_where_it_is_free():
    free = np.where(np.arange(360) < 90, np.inf, SOUND)
    for ranges in (SOUND, free):
        check = check_sweep(ranges, 10.0, SOUND + 0.01)
        assert check.usable.all()
        assert (check.invalid, check.stuck, check.repeated) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("reading", [0.0, -1.0, 1e9, np.nan, -np.inf])
def test_impossible_readings_are_not_believed(reading):
    check = check_sweep(np.where(np.arange(360) < 90, reading, SOUND), 10.0, None)
    assert check.invalid == pytest.approx(0.25)


def test_noise_makes_a_run_of_one_value_impossible():
    # 36 beams, a tenth of the sweep, are a run; 35 may be a coincidence of a driver's rounding
    for n, stuck in ((36, 0.1), (35, 0.0)):
        check = check_sweep(np.where(np.arange(360) < n, 5.0, SOUND), 10.0, None)
        assert check.stuck == pytest.approx(stuck)
        assert check.usable.sum() == 360 - 360 * stuck


def test_free_beams_are_no_repetition():
    assert check_sweep(SOUND, 10.0, SOUND).repeated == 1.0
    assert check_sweep(np.full(360, np.inf), 10.0, np.full(360, np.inf)).repeated == 0.0
