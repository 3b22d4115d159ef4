"""The page on a ROS 2 robot: drive, destination, STOP, lost link; the robot's own word counts."""

import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from .rider import Rider
from .served import Chair, held, moves, stands, wants
from .test_trip_choices import pixel

pytestmark = pytest.mark.slow
ROBOT = Path(__file__).parents[2] / "examples" / "ros2_robot.py"
DOMAIN = 74
STOP_TIME = 0.35
"""Bound of the issue: a zero at the base within 0.3 s and one control step."""
FILE = f"""
platform:
  use: ros2
  map: /map
  dds: {{interface: lo, domain: {DOMAIN}}}
  wait: 60
max_speed: 0.6
scenario: {{gate: {{scan_limit: 0.25, pose_limit: 0.25}}}}
"""


class Robot:
    """The robot's process: when which speed arrived there."""

    def __init__(self):
        command = [sys.executable, str(ROBOT), "hospital", "--people", "0", "--domain", str(DOMAIN)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.speeds = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            _, arrival, speed = json.loads(line)
            self.speeds.append((arrival, speed))

    def last_motion(self):
        return max(arrival for arrival, speed in self.speeds if speed)

    def close(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


@pytest.fixture(scope="module")
def robot():
    made = Robot()
    yield made
    made.close()


@pytest.fixture(scope="module")
def chair(robot, browser, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ros2")
    (folder / "robot.yaml").write_text(FILE)
    with Chair(folder, str(folder / "robot.yaml"), command="ros2") as chair:
        yield chair


@pytest.fixture
def rider(browser, chair):
    made = Rider(browser, chair, viewport={"width": 1280, "height": 800})
    made.sees("No driver.")
    yield made
    faults = made.faults
    made.close()
    chair.until(lambda state: state["driver"] is None and stands(state))
    assert faults == []


def test_the_stick_of_the_page_moves_the_robot(rider, robot):
    rider.take()
    rider.hold("ArrowUp")
    rider.makes(moves, lambda: None)
    assert time.time() - robot.last_motion() < 0.5
    rider.let_go("ArrowUp")
    rider.until(stands)


def test_a_destination_on_the_map_is_driven_to(rider, chair):
    rider.take()
    x, y, _ = chair.state["pose"]
    rider.press("Whole floor")
    rider.page.mouse.click(*pixel(rider, x, y + 2.0))
    rider.press("Go here")
    rider.press("Start")
    rider.until(lambda state: state["goal"])
    rider.makes(moves, rider.go_on)
    rider.until(lambda state: state["goal"] is None, within=60.0)
    assert abs(chair.state["pose"][1] - y - 2.0) < 0.4


def test_stop_reaches_the_base_and_nothing_moves_until_go_on(rider, robot):
    rider.take()
    rider.hold()
    rider.press("STOP")
    pressed = time.time()
    rider.until(lambda state: stands(state) and state["link"] == "stick_held")
    rider.holds(held, 1.0)
    assert robot.last_motion() - pressed < STOP_TIME
    rider.let_go()
    rider.until(lambda state: state["link"] == "confirm")
    rider.holds(held)
    rider.go_on()
    rider.hold()
    rider.let_go()


def test_a_page_whose_link_is_cut_stops_the_base(rider, robot):
    rider.take()
    rider.hold()
    rider.makes(wants, lambda: None)
    cut = time.time()
    rider.cable.cut()
    rider.sees("The chair does not respond. It stops by itself.")
    rider.until(held)
    assert robot.last_motion() - cut < STOP_TIME
