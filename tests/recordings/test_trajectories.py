"""Recorded trajectories of people."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.errors import RecordingError
from cohelm.recordings import read_groups, read_trajectories


def obsmat(folder, rows, name="obsmat.txt"):
    """Rows of (frame, id, x, y); velocities and height are noise."""
    file = folder / name
    file.write_text("".join(f" {f} {i} {x} 9.9 {y} 7.0 8.0 9.0\n" for f, i, x, y in rows))
    return file


def walk(folder, path, frames=range(0, 66, 6), who=1):
    return obsmat(folder, [(f, who, *path(0.4 * f / 6)) for f in frames])


def test_a_straight_walk_is_straight_between_the_frames_and_its_velocity_constant(tmp_path):
    walks = read_trajectories(walk(tmp_path, lambda t: (1.0 + 1.2 * t, 2.0 - 0.5 * t)))
    assert walks.step == 0.4
    for t in np.linspace(0.0, 4.0, 37):
        ids, position, velocity = walks.at(t)
        assert list(ids) == [1]
        assert position[0] == pytest.approx([1.0 + 1.2 * t, 2.0 - 0.5 * t], abs=1e-9)
        assert velocity[0] == pytest.approx([1.2, -0.5], abs=1e-9)


def test_a_steady_acceleration_is_met_exactly_within(tmp_path):
    # the tangent of the parabola through three points of a parabola is its own
    walks = read_trajectories(walk(tmp_path, lambda t: (t * t, 3.0)))
    for t in np.linspace(0.4, 3.6, 20):
        _, position, velocity = walks.at(t)
        assert position[0] == pytest.approx([t * t, 3.0], abs=1e-9)
        assert velocity[0] == pytest.approx([2.0 * t, 0.0], abs=1e-9)


def test_a_missing_frame_does_not_bend_a_parabola(tmp_path):
    frames = [0, 6, 12, 24, 30, 36]
    walks = read_trajectories(walk(tmp_path, lambda t: (t * t, 3.0), frames))
    assert walks.at(1.1)[1][0, 0] == pytest.approx(1.1**2)


@given(seed=st.integers(0, 1000), t=st.floats(0.01, 3.98))
def test_the_velocity_is_the_derivative_of_the_position(tmp_path_factory, seed, t):
    rng = np.random.default_rng(seed)
    rows = [(f, 1, *rng.normal(size=2)) for f in range(0, 110, 10)]
    walks = read_trajectories(obsmat(tmp_path_factory.mktemp("walks"), rows))
    near = [walks.at(t + e) for e in (-1e-6, 0.0, 1e-6)]
    slope = (near[2][1] - near[0][1]) / 2e-6
    assert near[1][2] == pytest.approx(slope, abs=1e-4)


def test_nobody_lives_outside_their_life_nor_in_a_long_gap(tmp_path):
    rows = [(f, 1, f, 0.0) for f in (0, 6, 12, 60, 66)] + [(30, 7, 1.0, 2.0)]
    walks = read_trajectories(obsmat(tmp_path, rows))
    assert list(walks.id) == [1, 7]
    assert walks.at(-0.1)[0].size == 0
    assert walks.at(4.5)[0].size == 0
    # 48 frames are 8 steps
    assert walks.at(1.5)[0].size == 0
    assert list(walks.at(0.8)[0]) == [1]
    assert list(walks.at(4.2)[0]) == [1]
    ids, position, velocity = walks.at(2.0)
    assert (list(ids), position.tolist(), velocity.tolist()) == ([7], [[1.0, 2.0]], [[0.0, 0.0]])
    assert walks.begin.tolist() == pytest.approx([0.0, 2.0])
    assert walks.end.tolist() == pytest.approx([4.4, 2.0])


def test_two_who_take_turns_do_not_mix(tmp_path):
    rows = [(f, 1, f / 10, 0.0) for f in (0, 10, 20)] + [(f, 2, -f / 10, 5.0) for f in (10, 20, 30)]
    walks = read_trajectories(obsmat(tmp_path, sorted(rows)))
    assert walks.velocity[:3] == pytest.approx(np.tile([2.5, 0.0], (3, 1)))
    assert walks.velocity[3:] == pytest.approx(np.tile([-2.5, 0.0], (3, 1)))


def test_the_other_kinds_are_told_by_their_columns(tmp_path):
    (tmp_path / "export.txt").write_text("0 1.0 2.0 3.0\n10 1.0 2.4 3.0\n20 1.0 ? ?\n")
    walks = read_trajectories(tmp_path / "export.txt")
    assert (walks.step, walks.time.tolist()) == (0.4, [0.0, 0.4])
    assert walks.at(0.2)[2][0] == pytest.approx([1.0, 0.0])
    assert read_trajectories(tmp_path / "export.txt", step=0.8).end == pytest.approx([0.8])

    (tmp_path / "hermes.txt").write_text("4 16 100 200 180\n4 17 110 200 180\n")
    walks = read_trajectories(tmp_path / "hermes.txt")
    assert walks.position.tolist() == [[1.0, 2.0], [1.1, 2.0]]
    # 10 cm in 1/16 s
    assert walks.velocity[0] == pytest.approx([1.6, 0.0])


def test_the_groups_beside_the_file_are_read(tmp_path):
    rows = [(0, i, i, 0.0) for i in range(4)]
    (tmp_path / "hall_groups.txt").write_text(" 0 2\n  \n1 3 3\n\n")
    file = obsmat(tmp_path, rows, "hall_obsmat.txt")
    assert read_trajectories(file).groups == ((0, 2), (1, 3))
    (tmp_path / "other.txt").write_text("2 3\n")
    assert read_trajectories(file, groups=tmp_path / "other.txt").groups == ((2, 3),)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "empty"),
        ("\n  \n", "empty"),
        ("0 1 2 3\n10 1 2\n", "line 2"),
        ("0 1 2 3\n10 1 two 3\n", "line 2"),
        ("0 1 2 3\n10 1 nan 3\n", "line 2"),
        ("0 1 2 inf\n", "line 1"),
        ("1 2 3\n", "3 columns"),
        ("0 1 ? ?\n", "no positions"),
        ("0 1.5 2 3\n", "whole number"),
        ("0 1 2 3\n0 1 2 3\n", "twice"),
        ("0 1 1e300 3\n", "beyond"),
    ],
)
def test_what_makes_no_sense_is_said_with_its_place(tmp_path, text, says):
    file = tmp_path / "walks.txt"
    file.write_text(text)
    with pytest.raises(RecordingError, match=says) as error:
        read_trajectories(file)
    assert str(file) in str(error.value)


def test_other_things_than_text_are_refused(tmp_path):
    (tmp_path / "picture.txt").write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff")
    with pytest.raises(RecordingError, match="at byte 0: is not text"):
        read_trajectories(tmp_path / "picture.txt")
    for file in (tmp_path, tmp_path / "absent.txt"):
        with pytest.raises(RecordingError):
            read_trajectories(file)
    (tmp_path / "groups.txt").write_text("1 2\n3 four\n")
    with pytest.raises(RecordingError, match="line 2"):
        read_groups(tmp_path / "groups.txt")


@given(st.text(alphabet="0123456789.-e ?\nax", max_size=80))
def test_any_text_gives_walks_or_says_why_not(tmp_path_factory, text):
    file = tmp_path_factory.mktemp("any") / "walks.txt"
    file.write_text(text)
    try:
        walks = read_trajectories(file)
    except RecordingError:
        return
    assert np.isfinite(walks.velocity).all()
    for t in walks.instants:
        assert np.isfinite(walks.at(t)[1]).all()


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "people", "groups", "step"),
    [
        ("eth_obsmat.txt", 360, 61, 0.4),
        ("zara01_obsmat.txt", 148, 45, 0.4),
        ("hermes_uo-050-180-180.txt", 61, 0, 0.0625),
        ("sociallstm_crowds_zara01.txt", 183, 0, 0.4),
    ],
)
def test_the_published_walks(data, name, people, groups, step):
    walks = read_trajectories(data / "pedestrians" / name)
    assert (len(walks.id), len(walks.groups), walks.step) == (people, groups, step)
    assert set().union(*walks.groups) <= set(walks.id.tolist())
    speed = np.hypot(*walks.velocity.T)
    assert 0.3 < np.median(speed) < 1.5


HEADER = "# description: corridor\n# framerate: 25.00\n#geometry: geometry.xml\n\n"


def walkers(file, *, header="", scale=1.0, columns="{id} {frame} {x:.6f} {y:.6f} 1.76", people=3):
    """People who walk 1.2 m/s along x at 25 frames per second, for 4 s."""
    rows = [
        columns.format(id=k, frame=50 + n, x=scale * 1.2 * n / 25.0, y=scale * k)
        for k in range(1, people + 1)
        for n in range(100)
    ]
    file.write_text(header + "\n".join(rows) + "\n")
    return file


@pytest.mark.parametrize(
    ("header", "scale"),
    [
        (HEADER + "# PersID\tFrame\tX\tY\tZ\n", 1.0),
        (HEADER + "# id frame x/m y/m z/m\n", 1.0),
        (HEADER + "# id frame x/cm y/cm z/cm\n", 100.0),
        ("#framerate: 25 fps\n# positions in cm\n", 100.0),
        ("# Frame rate = 25\n# unit: mm\n", 1000.0),
    ],
)
@pytest.mark.parametrize(
    "columns", ["{id} {frame} {x:.6f} {y:.6f}", "{id}\t{frame}\t{x:.6f}\t{y:.6f}\t1.76"]
)
def test_a_header_names_frame_rate_and_unit(tmp_path, header, scale, columns):
    file = walkers(tmp_path / "walk.txt", header=header, scale=scale, columns=columns)
    found = read_trajectories(file)
    assert found.step == pytest.approx(0.04)
    assert np.hypot(*found.velocity.T) == pytest.approx(1.2, abs=1e-3)
    assert found.id.tolist() == [1, 2, 3]


def test_a_header_without_frame_rate_needs_the_step(tmp_path):
    file = walkers(tmp_path / "walk.txt", header="# id frame x/m y/m z/m\n")
    with pytest.raises(RecordingError, match=r"walk\.txt: .*no frame rate: give the step"):
        read_trajectories(file)
    assert np.median(read_trajectories(file, step=0.04).velocity[:, 0]) == pytest.approx(1.2)


@pytest.mark.parametrize("header", ["", HEADER])
@pytest.mark.parametrize(("unit", "likely"), [("cm", "m"), ("mm", "m"), ("m", "cm"), ("m", "mm")])
def test_a_scale_at_which_nobody_walks_is_refused_with_the_likely_unit(
    tmp_path, header, unit, likely
):
    scale = {"m": 1.0, "cm": 100.0, "mm": 1000.0}[likely]
    file = walkers(tmp_path / "walk.txt", header=header, scale=scale)
    with pytest.raises(RecordingError, match=rf"in {unit} .* the unit is probably {likely}:"):
        read_trajectories(file, unit=unit, step=0.04)
    assert read_trajectories(file, unit=likely, step=0.04).step == 0.04


def test_people_who_stand_are_no_wrong_scale(tmp_path):
    rows = [f"{k} {n} {k}.0 2.0 1.7" for k in (1, 2) for n in range(9)]
    (tmp_path / "queue.txt").write_text(HEADER + "\n".join(rows))
    assert not read_trajectories(tmp_path / "queue.txt").velocity.any()


def test_trajectories_of_the_juelich_archive(data):
    found = read_trajectories(data / "pedestrians" / "juelich_UNI_CORR_500_01.txt")
    assert (len(found.id), found.step) == (148, 0.04)
    assert np.median(np.hypot(*found.velocity.T)) == pytest.approx(1.45, abs=0.01)
    assert np.ptp(found.position, axis=0) == pytest.approx([10.15, 4.49], abs=0.01)
