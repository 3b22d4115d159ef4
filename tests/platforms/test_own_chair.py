"""The Python platform of docs/your-robot.md drives a chair behind a serial line."""

import contextlib
import json
import os
import re
import threading
import time
import tty
from pathlib import Path

import numpy as np
import pytest
import yaml

from cohelm.cli import drive
from cohelm.cli.platform_file import PlatformFile
from cohelm.cli.requests import DriveRequest
from cohelm.config import load
from cohelm.errors import CohelmError, PlatformError
from cohelm.maps import write_map
from cohelm.platforms import is_simulated, open_platform, open_simulation
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.scenarios.build import floor_of
from cohelm.testing import check_open_platform, check_platform

GUIDE = Path(__file__).parents[2] / "docs" / "your-robot.md"


class Controller:
    """A chair's controller at the other end of the line: it follows each command at once."""

    def __init__(self):
        self.ours, theirs = os.openpty()
        tty.setraw(theirs)
        self.port, self._theirs = os.ttyname(theirs), theirs
        self.pose, self.v, self.w, self.ends = np.array([3.0, 4.0, 0.0]), 0.0, 0.0, False
        for work in (self._send, self._take):
            threading.Thread(target=work, daemon=True).start()

    def _send(self):
        for k in range(10_000):
            if self.ends:
                return
            x, y, yaw = self.pose
            step = 0.05 * self.v
            self.pose = np.array(
                [x + step * np.cos(yaw), y + step * np.sin(yaw), yaw + 0.05 * self.w]
            )
            state = {"pose": self.pose.tolist(), "v": self.v, "w": self.w}
            if k % 2 == 0:
                state["ranges"] = [4.0] * 180
            os.write(self.ours, json.dumps(state).encode() + b"\n")
            time.sleep(0.05)

    def _take(self):
        with contextlib.suppress(OSError, ValueError):
            for line in open(self.ours, "rb", buffering=0, closefd=False):  # noqa: SIM115  # the descriptor stays open
                command = json.loads(line)
                self.v, self.w = command["v"], command["w"]

    def close(self):
        self.ends = True
        time.sleep(0.1)
        os.close(self._theirs)


@pytest.fixture
def folder(tmp_path):
    blocks = dict(re.findall(r"```\w+\n# ([\w.-]+)[^\n]*\n(.*?)```", GUIDE.read_text(), re.DOTALL))
    (tmp_path / "my_chair.py").write_text(blocks["my_chair.py"])
    (tmp_path / "chair.yaml").write_text(blocks["chair-on-a-port.yaml"])
    (tmp_path / "robot.yaml").write_text(blocks["robot.yaml"])
    write_map(floor_of(load_scenario("empty")).grid, tmp_path / "floor.yaml")
    return tmp_path


@pytest.fixture
def controller():
    made = Controller()
    yield made
    made.close()


@pytest.fixture
def setup_of(folder):
    def made(**changes):
        file = folder / "chair.yaml"
        given = yaml.safe_load(file.read_text()) | {"robot": "quantum_q6_edge"} | changes
        file.write_text(yaml.safe_dump({key: each for key, each in given.items() if each}))
        with contextlib.ExitStack() as files:
            request = DriveRequest(platform=str(file), data=folder / "data")
            setup = drive.drive_setup(request, files)
            return setup, build_scenario(setup.scenario, 0)

    return made


def test_the_platform_of_the_guide_keeps_the_contract(setup_of, controller):
    platform = {"use": "my_chair:MyChair", "port": controller.port}
    setup, ride = setup_of(platform=platform)
    assert not is_simulated(setup.scenario)
    assert setup.limits.max_speed == 0.2
    seen = check_open_platform(open_platform(ride), wait=time.sleep)
    assert seen[-1].pose[0] == pytest.approx(3.2, abs=0.05)  # 0.2 m/s for 1 s
    assert (controller.v, controller.w) == (0.0, 0.0)


def test_a_line_that_is_missing_is_named(setup_of):
    _, ride = setup_of(platform={"use": "my_chair:MyChair", "port": "/dev/nothing"})
    with pytest.raises(PlatformError, match="/dev/nothing"):
        open_platform(ride)


def test_a_wrong_parameter_is_named_with_the_chair_s_own_file(setup_of):
    _, ride = setup_of(platform={"use": "luci", "port": 99_999_999})
    with pytest.raises(CohelmError, match=r"chair\.yaml: platform\.port"):
        open_platform(ride)


def test_without_a_map_the_floor_is_open_about_the_origin(setup_of, controller):
    setup, ride = setup_of(map=None)
    assert not ride.grid.blocked().any()
    assert ride.grid.contains(np.zeros(2))
    assert setup.scenario.start[:2] == (0.0, 0.0)


def test_a_real_chair_cannot_be_simulated(setup_of, controller):
    _, ride = setup_of(platform={"use": "my_chair:MyChair", "port": controller.port})
    with pytest.raises(CohelmError, match="cohelm drive"):
        open_simulation(ride)


def test_a_real_platform_s_plugin_passes_its_check(folder, monkeypatch):
    monkeypatch.syspath_prepend(str(folder))
    from my_chair import MyChair

    check_platform(MyChair(MyChair.Parameters()))


def test_the_ros_2_file_of_the_guide_is_valid(folder):
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    from cohelm.config import validate
    from cohelm.ros2.parameters import Ros2Parameters

    given = load(PlatformFile, folder / "robot.yaml")
    data = {key: each for key, each in given.platform.items() if key != "use"}
    assert validate(Ros2Parameters, data).scans == ("/scan",)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("platform: ros2\nspeed: 3", "speed"),
        ("robot: jackal", "platform"),
        ("platform: {use: 'my_chair:NoChair'}", "NoChair"),
        ("platform: rso2", "ros2"),
    ],
)
def test_a_wrong_file_is_refused_by_name(folder, text, problem):
    file = folder / "wrong.yaml"
    file.write_text(text)

    def refused():
        with contextlib.ExitStack() as files:
            setup = drive.drive_setup(DriveRequest(platform=str(file)), files)
            is_simulated(setup.scenario)

    with pytest.raises(CohelmError, match=problem):
        refused()
