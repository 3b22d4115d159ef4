"""The log of a live ride: the same measures as the evaluation's, in memory that does not grow."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from cohelm.errors import StoreError
from cohelm.evaluation import Episode
from cohelm.evaluation.metrics import measure
from cohelm.live.sessions import ride_log as module
from cohelm.live.sessions.measuring import measures_of, ride_of
from cohelm.live.sessions.ride_log import RideLogWriter
from cohelm.live.sessions.ride_rows import read_rows
from cohelm.messages import Decision, Reason
from cohelm.safety import stop
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import NewPedestrian
from cohelm.simulation.world import with_pedestrian

NOWHERE = np.full(2, np.nan)


@pytest.fixture(scope="module")
def ridden(tmp_path_factory):
    """A whole ride of the evaluation, its log as a live one, and its ticks."""
    file = tmp_path_factory.mktemp("rides") / "a.rows"
    ride_setup = build_scenario(load_scenario("distracted", ["rider=noisy"]), 1)
    book, seen = RideLogWriter(), []
    book.begin("a", file)

    def watch(tick, truth):
        seen.append((tick, truth))
        book.add(tick, truth)

    ride = Episode(ride_setup).run(watch)
    return ride_setup, ride, book.end("arrived"), seen


@pytest.fixture
def book(tmp_path):
    """A log in which a ride has begun."""
    book = RideLogWriter()
    book.begin("a", tmp_path / "a.rows")
    yield book
    book.end("cancelled")


def scenery(ride_setup):
    return ride_setup.scenario, ride_setup.robot, ride_setup.grid


def test_it_has_the_contradictions_to_the_map_so_far(ridden):
    _, _, log, seen = ridden
    assert log.changes is seen[-1][0].memory.health.changes


def test_it_measures_what_the_evaluation_measures(ridden):
    """Rows are single precision: 1e-7 of 10 m, twice differenced over 0.05 s, is 4e-4 m/s³."""
    ride_setup, ride, log, _ = ridden
    measured = measures_of(ride_of(log, *scenery(ride_setup)))
    expected = {name: float(each) for name, each in measure(ride).items() if np.isfinite(each)}
    assert measured.keys() == expected.keys()
    for name, number in expected.items():
        assert measured[name] == pytest.approx(number, rel=2e-4, abs=2e-3), name


def test_a_ride_that_was_cut_short_is_measured_as_far_as_its_last_whole_row(ridden, tmp_path):
    ride_setup, ride, log, _ = ridden
    torn = tmp_path / "torn.rows"
    rows = log.file.read_bytes()
    torn.write_bytes(rows[: len(rows) // 2 + 1])
    half = ride_of(replace(log, file=torn), *scenery(ride_setup))
    assert 0.4 * len(ride.time) < len(half.time) < 0.6 * len(ride.time)
    np.testing.assert_allclose(half.pose, ride.pose[: len(half.time)], atol=1e-5)
    with pytest.raises(StoreError, match="torn"):
        ride_of(replace(log, file=torn.with_name("torn-away.rows")), *scenery(ride_setup))


def test_memory_does_not_grow_with_the_ride(ridden, book, monkeypatch):
    """Ten minutes more are 12,000 ticks; a list of a number each would take 380 kB."""
    monkeypatch.setattr(module, "MAX_STOPS", 50)
    tick, truth = ridden[3][100]
    blocked = replace(tick, decision=Decision(twist=np.zeros(3), reason=Reason.BLOCKED))

    def drive(begin, end):
        for k in range(begin, end):
            # stops come every 2 s, so that there are more than are kept
            book.add(blocked if k % 40 == 0 else tick, replace(truth, time=0.05 * k))

    drive(0, 5_000)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    drive(5_000, 17_000)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 100_000
    assert len(book.end("cancelled").stops) == 50


def test_stops_are_told_without_coordinates(ridden, book):
    tick, truth = ridden[3][0]
    held = replace(tick, decision=stop(Reason.NO_PATH), planning_error="no way to (4.00, 7.00)")
    for _ in range(3):
        book.add(held, truth)
    (found,) = book.end("cancelled").stops
    assert found.text == Reason.NO_PATH.sentence


def test_who_comes_in_mid_ride_is_not_there_before(ridden, book):
    ride_setup, _, _, seen = ridden
    for k, (tick, truth) in enumerate(seen[:40]):
        if k >= 30:
            one = NewPedestrian(position=np.array([1.0, 2.0]), waypoints=np.empty((0, 2)))
            later = replace(
                truth,
                crowd=with_pedestrian(truth.crowd, one),
                gap_people=np.append(truth.gap_people, 3.0),
                hit_moving=np.append(truth.hit_moving, False),
                hit_standing=np.append(truth.hit_standing, False),
            )
        book.add(tick, truth if k < 30 else later)
    ride = ride_of(book.end("cancelled"), *scenery(ride_setup))
    assert np.isnan(ride.people[:30, -1]).all()
    assert np.isinf(ride.gap_people[:30, -1]).all()
    np.testing.assert_allclose(ride.people[30:, -1, :2], [[1.0, 2.0]] * 10)
    assert all(np.isfinite(number) for number in measures_of(ride).values())


def test_a_ride_to_nowhere_has_no_measures_of_a_destination(ridden, book):
    ride_setup, _, _, seen = ridden
    for tick, truth in seen[:40]:
        away = replace(tick, request=replace(tick.request, goal=NOWHERE), path=None)
        book.add(away, truth)
    measures = measures_of(ride_of(book.end("cancelled"), *scenery(ride_setup)))
    assert not {"success", "time", "spl", "stalled_time", "path_error"} & measures.keys()
    assert {"path_length", "min_distance", "jerk_rms"} <= measures.keys()


def test_outside_of_a_ride_nothing_is_kept(ridden, tmp_path):
    tick, truth = ridden[3][50]
    book = RideLogWriter()
    book.add(tick, truth)
    assert book.end("cancelled") is None
    book.begin("a", tmp_path / "a.rows")
    assert book.end("cancelled") is None
    book.begin("a", tmp_path / "a.rows")
    book.add(tick, truth)
    book.begin("b", tmp_path / "b.rows")
    assert book.end("cancelled") is None
    assert [file.name for file in tmp_path.iterdir()] == ["a.rows"]  # what was driven stays


def test_a_disk_that_takes_nothing_does_not_end_the_ride(ridden, tmp_path, caplog):
    tick, truth = ridden[3][50]
    book = RideLogWriter()
    book.begin("a", tmp_path / "nowhere" / "a.rows")
    assert "cannot be written" in caplog.text
    book.add(tick, truth)
    assert book.end("cancelled").ride == "a"


def test_nobody_else_reads_the_rows(ridden):
    assert ridden[2].file.stat().st_mode & 0o077 == 0


class SmallDisk:
    """A disk with so many bytes left, for the rows of a ride."""

    def __init__(self, left):
        self.left, self.os = left, module.os

    def __getattr__(self, name):
        return getattr(self.os, name)

    def pwrite(self, handle, row, at):
        some = row[: max(self.left, 0)]
        self.left -= len(row)
        if row and not some:
            raise OSError(28, "No space left on device")
        return self.os.pwrite(handle, some, at)


def test_rows_go_on_after_a_full_disk_and_none_is_cut(ridden, tmp_path, monkeypatch):
    """The disk is full for some ticks, in the middle of a row; they are missing and counted."""
    ticks = ridden[3][:40]
    disk = SmallDisk(10 * len(module.row_of_tick(*ticks[0], 0.0).tobytes()) + 100)
    monkeypatch.setattr(module, "os", disk)
    book = RideLogWriter()
    book.begin("a", tmp_path / "a.rows")
    for k, (tick, truth) in enumerate(ticks):
        if k == 30:
            assert "No space left" in book.error
            disk.left = 10**9
        book.add(tick, truth)
    assert book.error == ""
    log = book.end("arrived")
    assert log.lost_rows == 20
    chair, _ = read_rows(tmp_path / "a.rows")
    times = [truth.time - ticks[0][1].time for _, truth in (*ticks[:10], *ticks[30:])]
    assert chair[:, 0] == pytest.approx(times, abs=1e-4)


def test_a_killed_process_loses_no_row(ridden, tmp_path):
    """Rows are with the operating system after each tick: another reader sees them at once."""
    book = RideLogWriter()
    book.begin("a", tmp_path / "a.rows")
    for count, (tick, truth) in enumerate(ridden[3][:5], 1):
        book.add(tick, truth)
        assert len(read_rows(tmp_path / "a.rows")[0]) == count
