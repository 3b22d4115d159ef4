"""A recording in the page: served to this machine only, and the same ride as the file's."""

import json
import threading
import urllib.error
import urllib.request

import numpy as np
import pytest

from cohelm.errors import ConfigError, RecordingError
from cohelm.live.floor_model import recorded_floor
from cohelm.live.sessions.timeline import PERIOD, timeline_of_recording
from cohelm.recordings.bags.ros_messages import decode
from cohelm.recordings.rides.reader import RecordedRide
from cohelm.web.page_files import Asset
from cohelm.web.replay import replay_app, replay_server
from cohelm.web.server import listening

PAGE = {"replay.html": Asset(body=b"<html>", zipped=None, kind="text/html", tag="x", lasting=False)}


def test_the_timeline_is_the_recorded_ride(recorded):
    told = timeline_of_recording(recorded)
    ticks = list(RecordedRide(recorded))
    duration = ticks[-1].observation.time - ticks[0].observation.time
    assert len(told.pose) == len(told.speed) == len(told.eta) == len(told.people)
    assert (len(told.pose) - 1) * told.period == pytest.approx(duration, abs=told.period)
    assert told.period == PERIOD
    assert np.allclose(told.pose[0], ticks[0].observation.pose, atol=1e-3)
    assert np.allclose(told.pose[-1][:2], ticks[-1].observation.pose[:2], atol=0.1)
    assert told.floor.image.startswith("data:image/png;base64,")
    assert told.floor.solids is not None


def test_a_floor_that_is_not_on_this_machine_has_walls_without_names(recorded):
    facts = RecordedRide(recorded).facts
    content = {**facts.scenario, "floor": None, "map": "gone.yaml"}
    floor = recorded_floor(content, facts.grid)
    assert (floor.places, floor.solids) == ((), None)
    assert floor.image.startswith("data:image/png;base64,")


def test_it_is_served_with_its_page(recorded):
    app = replay_app(timeline_of_recording(recorded), PAGE, "127.0.0.1")
    ready = threading.Event()
    with listening("127.0.0.1", 0) as bound:
        server = replay_server(app, ready.set)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]})
        thread.start()
        assert ready.wait(20.0)
        address = f"http://127.0.0.1:{bound.getsockname()[1]}"
        try:
            with urllib.request.urlopen(f"{address}/") as answer:
                assert answer.read() == b"<html>"
                assert "default-src 'none'" in answer.headers["content-security-policy"]
            with urllib.request.urlopen(f"{address}/api/replay") as answer:
                assert json.load(answer)["period"] == PERIOD
            with pytest.raises(urllib.error.HTTPError, match="404"):
                urllib.request.urlopen(f"{address}/api/limits")
        finally:
            server.should_exit = True
            thread.join(20.0)


def test_other_machines_get_none(recorded):
    with pytest.raises(ConfigError, match="this machine only"):
        replay_app(timeline_of_recording(recorded), PAGE, "0.0.0.0")


def test_a_file_that_is_no_ride_says_so(tmp_path):
    file = tmp_path / "x.mcap"
    file.write_bytes(b"no")
    with pytest.raises(RecordingError, match="not an MCAP file"):
        timeline_of_recording(file)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Two seconds of a crossing."""
    from cohelm.evaluation.episode.recorded import run_recorded
    from cohelm.scenarios import load_scenario

    file = tmp_path_factory.mktemp("replay") / "ride.mcap"
    run_recorded(load_scenario("crossing", ["people.count=3", "time_limit=2.0"]), 1, file)
    return file


def test_damage_is_told_as_warnings(recorded, tmp_path):
    half, told = tmp_path / "half.mcap", []
    content = recorded.read_bytes()
    half.write_bytes(content[: len(content) // 2])
    shorter = timeline_of_recording(half, told.append)
    assert any("half.mcap" in text for text in told)
    assert len(shorter.pose) < len(timeline_of_recording(recorded).pose)


def test_messages_that_cannot_be_decoded_are_left_out(recorded, monkeypatch):
    whole, told = timeline_of_recording(recorded), []

    def short(message):
        cut = message.type.endswith("Float64")
        return decode(message._replace(data=message.data[:3]) if cut else message)

    monkeypatch.setattr("cohelm.live.sessions.timeline.decode", short)
    damaged = timeline_of_recording(recorded, told.append)
    assert any("damaged messages of /eta" in text for text in told)
    assert len(damaged.eta) == len(whole.eta)
    assert set(damaged.eta) == {0.0}
    assert damaged.pose == whole.pose
