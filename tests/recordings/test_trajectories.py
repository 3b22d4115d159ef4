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
