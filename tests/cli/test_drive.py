import math
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from cohelm.cli import drive as command
from cohelm.cli import web_server as door
from cohelm.cli.drive import scenario_of_drive
from cohelm.cli.requests import DriveRequest
from cohelm.scenarios.build import build_scenario
from cohelm.web.page_files import FOLDER

BUILT = (FOLDER / "index.html").is_file()


@pytest.fixture(autouse=True)
def page(monkeypatch):
    monkeypatch.setattr(door, "read_page", dict)


class Never:
    """No ride is begun where something is wrong before."""

    def __init__(self, setup):
        raise AssertionError(setup)


def refused(cohelm, *arguments):
    code, out, err = cohelm("drive", *arguments)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    return err


def test_without_the_extra_it_says_what_to_install(cohelm, monkeypatch):
    monkeypatch.setattr(command, "EXTRA", ("fastapi", "not_installed_at_all"))
    assert "not_installed_at_all missing): pip install 'cohelm[web]'" in refused(cohelm)


def test_without_the_page_it_says_how_to_build_it(cohelm, monkeypatch, tmp_path):
    from cohelm.web.page_files import read_page

    monkeypatch.setattr(door, "read_page", lambda: read_page(tmp_path))
    assert "make page" in refused(cohelm)


def test_a_port_that_is_taken(cohelm, monkeypatch, tmp_path):
    monkeypatch.setattr(door, "Drive", Never)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = refused(cohelm, "empty", "--port", port, "--data", tmp_path)
    assert said == f"error: --port {port}: is taken; name another, or 0 for any\n"


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("nowhere",), "nowhere"),
        (("empty", "--cert", "c.pem"), "belong together"),
        (("empty", "--cert", "c.pem", "--key", "k.pem"), "c.pem"),
        (("empty", "--host", "192.0.2.7"), "no such address"),
        (("empty", "--host", "no such host"), "no such address"),
        (("empty", "--record", "ride.txt"), "--record"),
        (("empty", "--robot", "wheelbarrow"), "wheelbarrow"),
        (("--map", "missing.yaml"), "missing.yaml"),
        (("empty", "--set", "no.key=1"), "no"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(cohelm, monkeypatch, tmp_path, arguments, word):
    monkeypatch.setattr(door, "Drive", Never)
    monkeypatch.chdir(tmp_path)
    assert word in refused(cohelm, *arguments, "--port", "0", "--data", tmp_path / "data")


def test_on_a_map_of_ones_own_the_chair_stands_where_there_is_room(room):
    """A room of 10 × 6 m about the origin: the middle line is farthest from its walls."""
    scenario = command.scenario_of_drive(DriveRequest(map=str(room)))
    x, y = scenario.start[:2]
    assert abs(y) < 0.11
    assert abs(x) <= 2.1


def test_a_code_for_a_camera_is_square():
    lines = door.qr_code("https://192.168.0.7:8000/#token=abcde").splitlines()
    widths = {len(line) for line in lines if line}
    assert len(widths) == 1
    assert abs(2 * len(lines) - widths.pop()) <= 3


TOLD = """
import sys
from cohelm.cli import (main)
from cohelm.cli import web_server as door
class Drive:
    failure = next_storey = None
    def __init__(self, setup): self.setup = setup
    def listen(self, callback): pass
    def start(self): pass
    def close(self): print("closed", flush=True)
door.Drive, door.read_page = Drive, dict
main(sys.argv[1:])
"""


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_it_ends_quietly_when_told_to(tmp_path, number):
    words = ["drive", "empty", "--port", "0", "--data", str(tmp_path)]
    with subprocess.Popen(
        [sys.executable, "-W", "error", "-c", TOLD, *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        lines = []
        while not lines or "Ctrl-C" not in lines[-1]:
            lines.append(process.stdout.readline())
            assert lines[-1], process.stderr.read()
        os.kill(process.pid, number)
        out, err = process.communicate(timeout=20.0)
    assert process.returncode == 0
    assert err == ""
    assert out == "closed\nstopped; the page is closed\n"
    assert lines[1].split()[:1] == ["drive"]
    assert "http://127.0.0.1:" in lines[1]
    assert "/therapist#token=" in lines[2]


def test_where_others_reach_it_it_takes_tls_and_a_token_and_says_them_once(tmp_path):
    words = ["drive", "empty", "--host", "0.0.0.0", "--port", "0", "--data", str(tmp_path)]
    with subprocess.Popen(
        [sys.executable, "-W", "error", "-c", TOLD, *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8",
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    ) as process:  # fmt: skip
        lines = []
        while not lines or "Ctrl-C" not in lines[-1]:
            lines.append(process.stdout.readline())
            assert lines[-1], process.stderr.read()
        os.kill(process.pid, signal.SIGINT)
        process.communicate(timeout=20.0)
    text = "".join(lines)
    assert text.count("https://") == 2
    assert "/#token=" in lines[1]
    assert "SHA-256" in text
    assert "▀" in text
    assert (tmp_path / "tls" / "key.pem").is_file()


@pytest.mark.skipif(not BUILT, reason="the page is not built: make page")
def test_a_wheel_has_the_page_in_it(tmp_path):
    import zipfile

    from hatchling.builders.wheel import WheelBuilder

    project = Path(__file__).parents[2]
    wheel = next(iter(WheelBuilder(str(project)).build(directory=str(tmp_path))))
    names = zipfile.ZipFile(wheel).namelist()
    assert {"index.html", "therapist.html"} <= {
        name.removeprefix("cohelm/web/page/") for name in names
    }
    assert any(name.startswith("cohelm/web/page/assets/") for name in names)
    assert "cohelm/web/messages.schema.json" in names
    assert not any("node_modules" in name for name in names)


def test_a_wheel_without_the_page_is_refused(tmp_path, monkeypatch):
    import importlib.util

    file = Path(__file__).parents[2] / "hatch_build.py"
    spec = importlib.util.spec_from_file_location("hatch_build", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)

    said = []
    app = SimpleNamespace(display_warning=said.append)
    hook = module.PageHook(str(tmp_path), {}, None, None, str(tmp_path), "wheel", app)
    with pytest.raises(RuntimeError, match="make page"):
        hook.initialize("standard", {})
    hook.initialize("editable", {})
    monkeypatch.setenv(module.WITHOUT, "1")
    hook.initialize("standard", {})
    assert len(said) == 1

    monkeypatch.setenv(module.KERNELS, str(tmp_path / "kernels"))
    with pytest.raises(RuntimeError, match="cohelm compile"):
        hook.initialize("standard", {})
    folder = tmp_path / "kernels" / "maps" / "__pycache__"
    folder.mkdir(parents=True)
    (tmp_path / "kernels" / "compiled.txt").touch()
    (folder / "f.nbi").touch()
    build = {"force_include": {}}
    hook.initialize("standard", build)
    assert set(build["force_include"].values()) == {
        "cohelm/compiled.txt",
        "cohelm/maps/__pycache__/f.nbi",
    }
    assert build["tag"].startswith("cp3")


def test_a_blocked_start_on_your_own_map_names_the_nearest_free_point(cohelm, room):
    code, out, err = cohelm("drive", "hospital", "--map", room, "--start=-4.95,0")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert err.startswith(
        "error: --start: the chair does not fit at -4.95,0.00; nearest free point"
    )


def test_a_ride_can_begin_at_the_point_that_is_named_as_free(cohelm, room):
    _, _, err = cohelm("drive", "hospital", "--map", room, "--start=-4.95,0")
    free = err.split("nearest free point ")[1].strip()
    scenario = scenario_of_drive(DriveRequest(map=str(room), start=free, people=0))
    assert build_scenario(scenario, 0).route.points.shape[1] == 2
    assert scenario.name == "hospital on room"


def test_close_to_a_wall_the_first_goal_is_where_a_goal_may_be(room):
    start = "0.3,-2.56"  # 0.34 m from the wall: the chair fits, a goal needs 0.35 m
    scenario = scenario_of_drive(DriveRequest(map=str(room), start=start, people=0))
    build_scenario(scenario, 0)
    assert scenario.goal != (0.3, -2.56)
    assert math.dist(scenario.goal, (0.3, -2.56)) < 0.2


@pytest.mark.skipif(not BUILT, reason="the page is not built: make page")
def test_a_scene_that_cannot_be_built_ends_it_with_one_line(cohelm, tmp_path):
    code, _, err = cohelm(
        "drive", "crossing", "--set", "goal=[-9.0, 0.0]", "--port", "0", "--data", tmp_path / "data"
    )
    assert code == 2
    assert err.startswith("error: ")
    assert "goal" in err
    assert len(err.splitlines()) == 1
