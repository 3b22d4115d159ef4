"""cohelm ground: the floor of a recording."""

import json
from importlib.resources import files

import numpy as np
import pytest
from PIL import Image


@pytest.fixture
def kerb(tmp_path):
    """A KITTI sweep of level floor 1.2 m below the sensor, 30 cm lower from 4 m on."""
    x, y = np.meshgrid(np.arange(-4.0, 5.2, 0.03), np.arange(-2.0, 2.0, 0.03))
    seen = (x < 4.0) | (x > 5.0)  # the edge hides the floor between
    z = np.where(x > 4.0, -1.5, -1.2)
    file = tmp_path / "000001.bin"
    np.stack([x, y, z, np.zeros_like(x)], axis=-1)[seen].astype("<f4").tofile(file)
    return file


def test_an_edge_is_reported_and_drawn_where_it_is(cohelm, kerb, tmp_path):
    plot = tmp_path / "ground.png"
    code, out, _ = cohelm("ground", kerb, "--plot", plot)
    assert code == 0
    assert "nearest edge" in out
    with Image.open(plot) as image:
        assert image.width > 300
    found = json.loads(cohelm("ground", kerb, "--json")[1])
    assert found["sweeps"] == 1
    assert found["area"]["floor"] > 10.0
    assert found["nearest_edge"]["distance"] == pytest.approx(4.0, abs=0.1)
    assert abs(found["nearest_edge"]["bearing"]) < 0.6


def test_what_the_chair_may_take_is_no_edge(cohelm, kerb, tmp_path):
    robot = tmp_path / "tall.yaml"
    known = files("cohelm.robots").joinpath("quantum_q6_edge_lidar.yaml").read_text()
    robot.write_text(known.replace("max_step_down: 0.05", "max_step_down: 0.4"))
    found = json.loads(cohelm("ground", kerb, "--json", "--robot", robot)[1])
    assert found["nearest_edge"] is None


def test_what_shows_no_floor_ends_with_one_line(cohelm, tmp_path):
    sky, rows = tmp_path / "sky.pcd", np.random.default_rng(0).uniform(5.0, 9.0, (200, 3))
    header = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 200\nHEIGHT 1\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 200\nDATA ascii"
    )
    np.savetxt(sky, rows, header=header, comments="")
    code, _, err = cohelm("ground", sky)
    assert code == 2
    assert "shows no floor" in err
    assert err.count("\n") == 1
