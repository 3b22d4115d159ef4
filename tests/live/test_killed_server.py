"""A program that is killed in mid-ride, or whose disk is full: no ride is lost without a word."""

import contextlib
import multiprocessing
import os
import resource
import signal
import time

import pytest

from cohelm.live import Drive, DriveSetup
from cohelm.live.messages import ResumeCommand
from cohelm.live.sessions.store import SessionStore
from cohelm.scenarios import load_scenario

from .test_drive import Page

pytestmark = pytest.mark.slow

RIDE = 4.0
"""Duration of the ride before the program is killed, s."""
PATIENCE = 500.0
"""Time for a busy computer to get the chair ready, s: below the bound of a hanging test."""
SLOWER = 0.2
"""Limit that a therapist sets in mid-ride, m/s."""
spawn = multiprocessing.get_context("spawn")


def ready_drive(folder):
    """A drive that is ready, and the page that drives it."""
    drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=folder))
    drive.start()
    while not drive.health.ready:
        time.sleep(0.05)
    page = Page(drive, "a")
    page.drives()
    return drive, page


def push(page, speed=0.7):
    """Push the stick; after a stop by a busy computer release it and confirm first, as a driver.

    How often a busy computer stops the chair is no matter of these tests.
    """
    if page.state.link == "ready":
        page.stick = (speed, 0.0)
        return
    page.stick = (0.0, 0.0)
    if page.state.link == "confirm":
        page.say(ResumeCommand())


def push_until(page, holds, speed=0.7):
    """Push until something holds of the state."""
    end = time.monotonic() + PATIENCE
    while not holds(page.state):
        assert time.monotonic() < end, page.state
        push(page, speed)
        time.sleep(0.1)


def driving(folder, pipe, largest):
    """Drive; report the time of the simulation at the first motion, and then in every state.

    ``largest``: maximum size of a file from the first motion on, bytes: the disk is full beyond.
    """
    drive, page = ready_drive(folder)
    if largest is not None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.prlimit(drive.navigator_pid, resource.RLIMIT_FSIZE, (largest, largest))
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, resource.RLIM_INFINITY))
    push_until(page, lambda state: state.speed > 0.15)
    while True:
        push(page)
        pipe.send((page.state.time, page.state.speed, page.state.unstored, drive.unstored))
        time.sleep(0.1)


@contextlib.contextmanager
def started(target, folder, more):
    """Pipe from a program that is killed at the end; at its early death receiving fails at once."""
    ours, theirs = spawn.Pipe()
    process = spawn.Process(target=target, args=(folder, theirs, more))
    process.start()
    theirs.close()
    try:
        yield ours
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        ours.close()


def reports_of(folder, until, largest=None):
    """Reports of a program that drives until something holds, and is then killed."""
    reports = []
    with started(driving, folder, largest) as pipe:
        while not until(reports):
            assert pipe.poll(PATIENCE)
            reports.append(pipe.recv())
    return reports


def kept_in(folder):
    """Rides after the next start of the program."""
    store = SessionStore(folder)
    store.wait_until_idle()
    rides = [ride for session in store.list() for ride in session.rides]
    store.close()
    return rides


def test_the_ride_of_a_killed_program_is_kept_up_to_its_last_second(tmp_path):
    reports = reports_of(tmp_path, lambda seen: seen and seen[-1][0] - seen[0][0] > RIDE)
    assert not any(report[3] for report in reports)
    (ride,) = kept_in(tmp_path)
    driven = reports[-1][0] - reports[0][0]
    assert ride.duration >= driven - 1.0
    if ride.measures:  # else this machine was too busy; it is measured at the next start
        assert ride.measures["path_length"] == pytest.approx(ride.length, abs=0.1)
    assert "interrupted" in ride.error
    # And the program starts again in this folder.
    Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path)).close()


def test_a_full_disk_in_mid_ride_is_said_at_once_and_the_chair_drives_on(tmp_path):
    """No file may grow beyond 2 kB from the first motion on: after some twenty rows."""

    def said(seen):
        moves = seen and seen[-1][1] > 0.1
        return moves and seen[-1][2] and seen[-1][3] and seen[-1][0] - seen[0][0] > RIDE

    reports = reports_of(tmp_path, said, largest=2000)
    told = [report[2] for report in reports if report[2]]
    assert "not stored" in told[-1] or "The log of this ride" in told[-1]
    assert "Traceback" not in "".join(told)
    (ride,) = kept_in(tmp_path)
    assert ride.error


def limiting(folder, pipe, damage):
    """Drive fast, take the disk away, and lower the limit of the speed.

    Reports the time since then, the speed, what the page is told, and what health says.
    """
    drive, page = ready_drive(folder)
    push_until(page, lambda state: state.speed > 2.0 * SLOWER, 1.0)
    damage(folder)
    begun = page.state.time
    drive.set_limits(drive.limits.model_copy(update={"max_speed": SLOWER}), "therapist")
    while True:
        push(page, 1.0)
        state = page.state
        pipe.send((state.time - begun, state.speed, state.unstored, drive.unstored))
        time.sleep(0.05)


def full(folder):
    """Let no file grow any more, as a full disk does."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))


def gone(folder):
    """Put a file where the data folder was, as a disk that is no longer mounted."""
    folder.rename(folder.with_name("elsewhere"))
    folder.write_bytes(b"")


@pytest.mark.parametrize("damage", [full, gone])
def test_a_slower_limit_acts_at_once_whatever_the_disk_does(tmp_path, damage):
    """Within the braking from 0.5 to 0.2 m/s at the gentlest deceleration, and it is said."""
    folder = tmp_path / "sessions"
    reports = []
    with started(limiting, folder, damage) as pipe:
        while not reports or reports[-1][0] < 3.0 or not reports[-1][2]:
            assert pipe.poll(PATIENCE)
            reports.append(pipe.recv())
            assert reports[-1][0] < 15.0, reports[-1]
    late = [speed for since, speed, _, _ in reports if since > 2.0]
    assert max(late) < SLOWER + 0.03
    assert reports[-1][3]
    assert "Traceback" not in reports[-1][2]
