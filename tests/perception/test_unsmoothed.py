import numpy as np
import pytest

from cohelm.evaluation.perception.behaviour_changes import CHANGES, walk
from cohelm.evaluation.perception.tracked_film import detections
from cohelm.messages import Observation
from cohelm.perception import KalmanTracker
from cohelm.perception.prediction.hypotheses import axis_covariance, recover_measurements
from cohelm.perception.tracking.kalman import predict, update


@pytest.mark.parametrize("q", [0.05, 0.4, 3.0])
@pytest.mark.parametrize("doubt", [1.0, 2.5])
def test_finds_what_a_filter_saw_whatever_agitates_it(q, doubt):
    # two people through the filter itself; what goes in must come out again
    rng = np.random.default_rng(0)
    mean, covariance = rng.standard_normal((2, 4)), np.tile(0.2 * np.eye(4), (2, 1, 1))
    for dt in (0.1, 0.1, 0.25, 0.4):
        steps = np.full(2, dt)
        ahead, wide = predict(mean, covariance, steps, np.full(2, q))
        seen = ahead[:, :2] + 0.1 * rng.standard_normal((2, 2))
        after, narrow = update(ahead, doubt * wide, seen, np.full(2, 0.06))
        found, variance = recover_measurements(
            ahead[:, :2], axis_covariance(covariance), after[:, :2], axis_covariance(narrow), steps
        )
        assert found == pytest.approx(seen)
        assert variance == pytest.approx(np.full(2, 0.06**2))
        mean, covariance = after, narrow


def test_takes_as_it_is_what_no_filter_made():
    covariance = axis_covariance(np.tile(np.diag([0.01, 0.01, 0.1, 0.1]), (1, 1, 1)))
    found, variance = recover_measurements(
        np.zeros((1, 2)), covariance, np.ones((1, 2)), covariance, np.full(1, 0.1)
    )
    assert found.tolist() == [[1.0, 1.0]]
    assert variance == pytest.approx([0.01])


def looked_at(name, tracker, *, noise, dt, late=0.0, every=1):
    """What is found again of somebody who does ``name``: errors (k, 2) and variances (k,).

    Scans come every ``dt`` and are told ``late``; every so many of them are looked at. Errors are
    from what was detected then, or from where he was where it was another moment.
    """
    rng = np.random.default_rng(1)
    times, positions = walk(name, rng)
    memory = before = None
    errors, variances = [], []
    for k, time in enumerate(np.arange(0.5, times[-1] - 0.1, dt)):
        scanned, now = (
            np.array([[np.interp(t, times, axis) for axis in positions.T]])
            for t in (time, time + late)
        )
        seen = scanned + noise * rng.standard_normal((1, 2))
        told, memory = tracker.track(
            Observation.at_rest(time + late), (detections(time, seen, noise),), memory
        )
        if len(told) == 0 or k % every:
            continue
        if before is not None:
            since = told.time - before.time
            found, variance = recover_measurements(
                before.mean[:, :2] + since * before.mean[:, 2:],
                axis_covariance(before.covariance),
                told.mean[:, :2],
                axis_covariance(told.covariance),
                np.full(1, since),
            )
            errors.append(found[0] - (seen[0] if late == 0.0 and every == 1 else now[0]))
            variances.append(variance[0])
        before = told
    return np.array(errors), np.array(variances)


@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("agility", [0.1, None, 1.5])
@pytest.mark.parametrize("dt", [0.1, 0.2])
def test_finds_what_the_tracker_saw_however_it_is_set(name, agility, dt):
    # the tracker grows agile with surprise and doubts itself: neither may matter
    given = {} if agility is None else {"process_noise": agility}
    tracker = KalmanTracker(KalmanTracker.Parameters(**given))
    errors, variances = looked_at(name, tracker, noise=0.035, dt=dt)
    assert len(errors) >= 7
    assert np.abs(errors).max() < 1e-6
    assert variances == pytest.approx(np.full(len(variances), 0.035**2), rel=1e-4)


@pytest.mark.parametrize(("dt", "late", "every"), [(0.1, 0.05, 1), (0.1, 0.1, 1), (0.025, 0.0, 4)])
def test_is_honest_where_scans_are_old_or_several(dt, late, every):
    for name in CHANGES:
        errors, variances = looked_at(
            name, KalmanTracker(), noise=0.035, dt=dt, late=late, every=every
        )
        # some 35 looks at two axes know a mean square to about 17 %
        assert 0.4 < np.mean(errors**2) / np.mean(variances) < 1.3
        # errors that a tracker makes last; those of what was seen must not
        assert np.mean(errors[1:] * errors[:-1]) < 0.2 * np.mean(errors**2)
