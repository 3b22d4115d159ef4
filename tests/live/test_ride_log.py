"""The log of a live ride: the same measures as the evaluation's, in memory that does not grow."""

import os
import threading
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from cohelm.errors import StoreError
from cohelm.evaluation import Episode
from cohelm.evaluation.metrics import measure
from cohelm.live.sessions import measuring
from cohelm.live.sessions import ride_log as module
from cohelm.live.sessions.measuring import measures_of, read_log
from cohelm.live.sessions.records import RideBegin, unknown_ride, unknown_session
from cohelm.live.sessions.ride_log import RideLogWriter, facts_of_log
from cohelm.messages import Decision, Reason
from cohelm.safety import stop
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import NewPedestrian
from cohelm.simulation.world import with_pedestrian

NOWHERE = np.full(2, np.nan)
RIDE = "20260131-142530-r1"
RIDE_SETUP = build_scenario(load_scenario("distracted", ["rider=noisy"]), 1)


def begun(file, ride=RIDE):
    session = unknown_session(ride[:15], "ward").model_dump_json()
    return RideBegin(ride, file, session, unknown_ride(ride, "").model_dump_json())


def ended(book):
    """The answer to a ride that ends now."""
    book.end(unknown_ride(RIDE, "").model_copy(update={"outcome": "arrived"}).model_dump_json())
    book.close()
    return book.finished()


@pytest.fixture(scope="module")
def ridden(tmp_path_factory):
    """A whole ride of the evaluation, its live log, and its ticks."""
    file = tmp_path_factory.mktemp("rides") / "a.mcap"
    book, seen = RideLogWriter(lambda: facts_of_log(RIDE_SETUP)), []
    book.begin(begun(file))

    def watch(tick, truth):
        seen.append((tick, truth))
        book.add(tick, truth)

    ride = Episode(RIDE_SETUP).run(watch)
    return ride, ended(book), seen, file


@pytest.fixture
def book(tmp_path):
    """A log in which a ride has begun."""
    book = RideLogWriter(lambda: facts_of_log(RIDE_SETUP))
    book.begin(begun(tmp_path / "a.mcap"))
    yield book
    book.close()


def test_it_has_the_contradictions_to_the_map_so_far(ridden):
    _, log, seen, _ = ridden
    assert log.changes is seen[-1][0].memory.health.changes


def test_it_measures_what_the_evaluation_measures(ridden):
    """Rows are single precision: 1e-7 of 10 m, twice differenced over 0.05 s, is 4e-4 m/s³."""
    ride, _, _, file = ridden
    logged, summary, damage = read_log(file)
    assert damage == ""
    assert summary.duration == pytest.approx(ride.time[-1], abs=0.01)
    measured = measures_of(logged)
    expected = {name: float(each) for name, each in measure(ride).items() if np.isfinite(each)}
    assert measured.keys() == expected.keys()
    for name, number in expected.items():
        assert measured[name] == pytest.approx(number, rel=2e-4, abs=2e-3), name


def test_a_ride_that_was_cut_short_is_measured_as_far_as_it_is_there(ridden, tmp_path):
    ride, _, _, file = ridden
    torn = tmp_path / "torn.mcap"
    content = file.read_bytes()
    for length in np.linspace(0, len(content), 30).astype(int)[:-1]:
        torn.write_bytes(content[:length])
        try:
            half, _, damage = read_log(torn)
        except StoreError:  # before the first tick
            continue
        assert "cut off" in damage
        np.testing.assert_allclose(half.pose, ride.pose[: len(half.time)], atol=1e-5)
    assert len(half.time) == len(ride.time)  # only the index was missing
    for garbage in (content[:5], b"garbage" * 50):
        torn.write_bytes(garbage)
        with pytest.raises(StoreError, match=r"torn\.mcap: cannot be read"):
            read_log(torn)


def test_the_log_is_on_disk_after_each_second_in_spite_of_a_disk_that_hangs(
    ridden, book, tmp_path, monkeypatch
):
    """No tick waits for the disk: the file is a reader's, the ride goes on."""
    hangs, real = threading.Event(), os.fsync
    monkeypatch.setattr(module.os, "fsync", lambda handle: (hangs.wait(10.0), real(handle)))
    began = time.monotonic()
    for tick, truth in ridden[2][:100]:
        book.add(tick, truth)
    assert time.monotonic() - began < 5.0
    hangs.set()
    end = time.monotonic() + 20.0
    count = 0
    while count < 100 and time.monotonic() < end:
        time.sleep(0.1)
        try:
            count = len(read_log(tmp_path / "a.mcap")[0].time)
        except StoreError:
            continue
    assert count == 100


def test_memory_does_not_grow_with_the_ride(ridden, book):
    """Ten minutes more are 12,000 ticks; a list of a number each would take 380 kB."""
    tick, truth = ridden[2][100]

    def drive(begin, end):
        for k in range(begin, end):
            book.add(tick, replace(truth, time=0.05 * k))
            while not book._queue.empty():
                time.sleep(0.0005)

    drive(0, 3_000)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    drive(3_000, 6_000)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 300_000


def test_the_longest_stops_are_told_without_coordinates(ridden, book, tmp_path, monkeypatch):
    monkeypatch.setattr(measuring, "MAX_STOPS", 2)
    tick, truth = ridden[2][0]
    held = replace(tick, decision=stop(Reason.NO_PATH), planning_error="no way to (4.00, 7.00)")
    free = replace(tick, decision=Decision(twist=np.zeros(3)))
    for k in range(300):
        stands = k in range(10, 14) or k in range(100, 130) or k in range(200, 210)
        book.add(held if stands else free, replace(truth, time=0.05 * k))
    ended(book)
    stops = read_log(tmp_path / "a.mcap")[1].stops
    assert [(each.time, each.text) for each in stops] == [
        (pytest.approx(5.0), Reason.NO_PATH.sentence),
        (pytest.approx(10.0), Reason.NO_PATH.sentence),
    ]


def test_who_comes_in_mid_ride_is_not_there_before(ridden, book, tmp_path):
    for k, (tick, truth) in enumerate(ridden[2][:40]):
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
    ended(book)
    ride, _, _ = read_log(tmp_path / "a.mcap")
    assert np.isnan(ride.people[:30, -1]).all()
    assert np.isinf(ride.gap_people[:30, -1]).all()
    np.testing.assert_allclose(ride.people[30:, -1, :2], [[1.0, 2.0]] * 10)
    assert all(np.isfinite(number) for number in measures_of(ride).values())


def test_a_ride_to_nowhere_has_no_measures_of_a_destination(ridden, book, tmp_path):
    for tick, truth in ridden[2][:40]:
        away = replace(tick, request=replace(tick.request, goal=NOWHERE), path=None)
        book.add(away, truth)
    ended(book)
    measures = measures_of(read_log(tmp_path / "a.mcap")[0])
    assert not {"success", "time", "spl", "stalled_time", "path_error"} & measures.keys()
    assert {"path_length", "min_distance", "jerk_rms"} <= measures.keys()


def test_each_ride_has_its_file_that_nobody_else_reads(ridden, tmp_path):
    tick, truth = ridden[2][50]
    book = RideLogWriter(lambda: facts_of_log(RIDE_SETUP))
    book.add(tick, truth)  # outside of a ride
    for name in ("a", "b"):
        book.begin(begun(tmp_path / f"{name}.mcap"))
        book.add(tick, truth)
    assert ended(book).ride == RIDE
    assert book.finished() is None
    assert {file.name for file in tmp_path.iterdir()} == {"a.mcap", "b.mcap"}
    for file in tmp_path.iterdir():
        assert len(read_log(file)[0].time) == 1
        assert file.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("space", [0, 3])
def test_a_full_disk_ends_no_ride_and_what_it_rejects_is_stored_later(
    ridden, tmp_path, monkeypatch, space
):
    """It takes some bytes of a second in the middle of the ride, and then none for a while."""
    monkeypatch.setattr(module, "FLUSH", 0.05)
    real, full = os.pwrite, threading.Event()

    def pwrite(handle, data, at):
        if full.is_set():
            if space and len(data) > space:
                return real(handle, data[:space], at)
            raise OSError(28, "No space left on device")
        return real(handle, data, at)

    monkeypatch.setattr(module.os, "pwrite", pwrite)
    book = RideLogWriter(lambda: facts_of_log(RIDE_SETUP))
    book.begin(begun(tmp_path / "a.mcap"))
    ticks = ridden[2][:60]
    for k, (tick, truth) in enumerate(ticks):
        if k == 20:
            full.set()
        book.add(tick, truth)
        time.sleep(0.02)
        if k == 40:
            assert "No space left" in book.error
            full.clear()
    log = ended(book)
    assert (book.error, log.lost_ticks) == ("", 0)
    times = [truth.time - ticks[0][1].time for _, truth in ticks]
    assert read_log(tmp_path / "a.mcap")[0].time == pytest.approx(times, abs=1e-4)


def test_what_a_disk_never_takes_is_counted(ridden, tmp_path, caplog):
    book = RideLogWriter(lambda: facts_of_log(RIDE_SETUP))
    (tmp_path / "nowhere").write_text("a file")
    book.begin(begun(tmp_path / "nowhere" / "a.mcap"))
    for tick, truth in ridden[2][:5]:
        book.add(tick, truth)
    assert ended(book).lost_ticks == 5
    assert "cannot be written" in caplog.text
