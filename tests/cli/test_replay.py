"""``cohelm run --record`` and ``cohelm replay``."""

import json
from dataclasses import replace

import pytest

from cohelm.cli.app import status
from cohelm.messages import Reason
from cohelm.navigation import Navigator
from cohelm.recordings import RecordedRide
from cohelm.safety import stop

SHORT = ("run", "empty", "--set", "time_limit=1", "--quiet")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    file = tmp_path_factory.mktemp("replay") / "ride.mcap"
    assert status([*SHORT, "--record", str(file)]) == 1  # too short to arrive
    return file


def test_a_ride_is_replayed_the_same(cohelm, recorded):
    code, out, err = cohelm("replay", recorded)
    assert code == 0
    assert out == "equal to the bit: 21 ticks, 1.0 s\n"
    assert err == ""


def test_a_run_says_the_same_with_a_recording(cohelm, tmp_path):
    _, without, _ = cohelm(*SHORT, "--json")
    _, with_, _ = cohelm(*SHORT, "--json", "--record", tmp_path / "r.mcap")
    a, b = json.loads(without), json.loads(with_)
    assert {**a, "timing": 0} == {**b, "timing": 0}


def test_other_parameters_are_told_apart_with_the_first_tick(cohelm, recorded, tmp_path):
    picture = tmp_path / "replay.png"
    code, out, _ = cohelm(
        "replay", recorded, "--set", "profile.preferred_speed=0.1", "--plot", picture
    )
    assert code == 0  # it was asked for
    assert "first difference at " in out
    assert "recorded  " in out
    assert "replayed  " in out
    assert out.splitlines()[-1].startswith("different: ")
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_json_says_where_the_commands_part(cohelm, recorded):
    code, out, _ = cohelm("replay", recorded, "--planner", "apf", "--json")
    assert code == 0
    report = json.loads(out)
    first = report["first_difference"]
    assert report["different"] > 0
    assert not report["bit_equal"]
    assert first["time"] == pytest.approx(0.05 * first["tick"])
    assert first["recorded"]["twist"] != first["replayed"]["twist"]
    assert report["settings"] == ["local_planner=apf"]


def test_other_versions_are_named_and_a_tolerance_is_taken(cohelm, recorded, monkeypatch):
    facts = RecordedRide(recorded).facts
    older = {**facts.versions, "daqp": "0.0.1"}
    monkeypatch.setattr("cohelm.cli.replay.navigation_versions", lambda: older)
    code, out, _ = cohelm("replay", recorded)
    assert code == 0
    assert f"recorded with other versions: daqp {facts.versions['daqp']} → 0.0.1" in out
    assert out.splitlines()[-1].startswith("equal within 0.001 m/s and rad/s: ")
    code, out, _ = cohelm("replay", recorded, "--tolerance", 0)
    assert out.splitlines()[-1].startswith("equal to the bit: ")


def test_a_command_that_differs_fails_and_both_are_said(cohelm, recorded, monkeypatch):
    step = Navigator.step

    def stopped(self, observation, request, last):
        tick = step(self, observation, request, last)
        if observation.time < 0.5:
            return tick
        return replace(tick, decision=stop(Reason.LATE))

    monkeypatch.setattr(Navigator, "step", stopped)
    code, out, _ = cohelm("replay", recorded)
    assert code == 1
    assert "first difference at 0.50 s, tick 10:" in out
    assert "replayed  0.0 m/s, 0.0 rad/s (late)" in out


def test_the_same_command_for_other_reasons_fails_too(cohelm, recorded, monkeypatch):
    """As of a chair that drives at full speed, whatever it sees."""

    def elsewhere(self, observation, request, last):
        tick = step(self, observation, request, last)
        return replace(tick, path=None) if observation.time > 0.52 else tick

    step = Navigator.step
    monkeypatch.setattr(Navigator, "step", elsewhere)
    code, out, _ = cohelm("replay", recorded)
    assert code == 1
    assert out.startswith("equal commands, but other intermediate results from 0.55 s: ")


def test_a_file_that_was_cut_off_is_replayed_with_a_warning(cohelm, recorded, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recorded.read_bytes()[:-300])
    code, out, err = cohelm("replay", cut)
    assert code == 0
    assert "equal to the bit" in out
    assert err.startswith("warning: ")
    assert "read until" in err


@pytest.mark.parametrize(
    ("content", "problem"), [(b"", "is empty"), (b"#ROSBAG V2.0\n", "is not an MCAP file")]
)
def test_what_is_no_ride_is_refused_in_one_line(cohelm, tmp_path, content, problem):
    file = tmp_path / "other.mcap"
    file.write_bytes(content)
    code, out, err = cohelm("replay", file)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert problem in err


def test_a_setting_of_the_world_is_refused(cohelm, recorded):
    code, _, err = cohelm("replay", recorded, "--set", "people.count=3")
    assert code == 2
    assert "people: determined the recording" in err


def test_a_recording_is_refused_before_riding_where_it_cannot_be_written(
    cohelm, recorded, tmp_path
):
    for file, problem in [
        (recorded, "exists already"),
        (tmp_path / "ride.bag", "FILE.mcap"),
        (tmp_path / "nowhere" / "ride.mcap", "no folder"),
    ]:
        code, out, err = cohelm(*SHORT, "--record", file)
        assert (code, out) == (2, "")
        assert "--record" in err
        assert problem in err
