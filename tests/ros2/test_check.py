"""``cohelm ros2 --check`` names each fault of a robot with its remedy."""

import builtins
import itertools

import pytest
import yaml

pytest.importorskip("rclpy", reason="needs rclpy, see CONTRIBUTING.md")

from cohelm.cli.app import status as run_command
from cohelm.maps import write_map
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import floor_of
from tests.ros2.lockstep import robot

pytestmark = [pytest.mark.ros, pytest.mark.slow]
SCENARIO = "hospital"  # its start is not symmetric, so that a mirrored scan shows
DOMAINS = itertools.count(60)
LOOPBACK = {"use": "ros2", "dds": {"interface": "lo"}, "wait": 20.0}

BROKEN = {
    "wrong frame": (
        ["scan_frame=lidar_x"],
        {},
        "no transform from 'base_link' to 'lidar_x'",
        "frames are",
    ),
    "missing tf": (
        ["no_laser_tf=1"],
        {},
        "no transform from 'base_link' to 'laser'",
        "static_transform",
    ),
    "no localiser": (["no_map_tf=1"], {}, "no transform", "AMCL"),
    "old stamps": (["old=0.5"], {}, "stamps are old", "stamp when it measures"),
    "wrong quality of service": (
        ["volatile_map=1"],
        {"map": "/map"},
        "no map, though",
        "transient local",
    ),
    "mirrored scan": (["mirrored=1"], {}, "mirrored", "upside down"),
    "scan upside down": (["roll=180"], {}, "mirrored", "roll 180"),
    "open map": (["open_map=1"], {"map": "/map"}, "no cell is unknown", "unknown cells"),
    "wrong topic": (
        ["scan_topic=/scan_front"],
        {},
        "nobody publishes it",
        "did you mean '/scan_front'",
    ),
    "twist without stamp": (["twist=1"], {}, "nobody subscribes", "stamped: false"),
    "no clock": ([], {"use_sim_time": True}, "no message on /clock", "use_sim_time"),
    "backwards": (["backwards=1"], {}, "backwards", "linear.x > 0 is forward"),
}  # fmt: skip


@pytest.fixture
def check(tmp_path, capsys, monkeypatch):
    """Run the command on a robot with faults; returns its status and what it prints."""
    # A domain for each test: the last robot, killed, counts as present for another 20 s.
    monkeypatch.setenv("ROS_DOMAIN_ID", str(next(DOMAINS)))
    write_map(floor_of(load_scenario(SCENARIO)).grid, tmp_path / "floor.yaml")

    def run(faults, changes, *options):
        file = tmp_path / "robot.yaml"
        given = {"platform": {**LOOPBACK, **changes}, "map": "floor.yaml"}
        if "map" in changes:
            del given["map"]
        file.write_text(yaml.safe_dump(given))
        with robot(SCENARIO, 0, *faults) as process:
            process.stdout.readline()
            status = run_command(["ros2", str(file), "--check", *options])
        return status, " ".join(capsys.readouterr().out.split())

    return run


def test_a_sound_robot_is_ready(check, tmp_path):
    status, text = check([], {}, "--plot", str(tmp_path / "seen.png"))
    assert status == 0, text
    assert "ready to drive" in text
    assert (tmp_path / "seen.png").stat().st_size > 5000


@pytest.mark.parametrize("fault", BROKEN)
def test_a_fault_is_named_with_its_remedy(check, fault, monkeypatch):
    faults, changes, problem, remedy = BROKEN[fault]
    monkeypatch.setattr(builtins, "input", lambda _: "yes")
    status, text = check(faults, changes, *(["--move"] if fault == "backwards" else []))
    assert status == 1, text
    assert problem in text
    assert remedy in text
