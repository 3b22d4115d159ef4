"""PCD files."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording
from cohelm.recordings.clouds.pcd import decompress_lzf

from .clouds import lzf, pcd

ENCODINGS = ["ascii", "binary", "binary_compressed"]


def opened(folder, data):
    """(cloud, recording) of a file with these bytes."""
    file = folder / "cloud.pcd"
    file.write_bytes(data)
    recording = open_recording(file)
    (frame,) = recording
    return frame.observation.clouds[0], recording


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize(
    ("fields", "kind", "size"),
    [("xyz", "F", 4), ("izyx", "F", 8), ("xayiz", "F", 4), ("zxy", "I", 2), ("xyz", "U", 1)],
)
def test_every_encoding_type_and_order_gives_the_points(
    tmp_path, rng, encoding, fields, kind, size
):
    points = np.round(rng.uniform(0.0, 90.0, (40, 3)), 0 if kind in "IU" else 3)
    cloud, recording = opened(tmp_path, pcd(points, encoding, fields, kind, size))
    assert cloud.points == pytest.approx(points.astype(np.float32))
    assert np.isnan(cloud.mount[2])
    assert cloud.range_max == pytest.approx(np.linalg.norm(points, axis=1).max())
    assert recording.warnings == []


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_rows_that_are_not_finite_are_kept(tmp_path, encoding):
    points = np.array([[1.0, 2.0, 3.0], [math.nan] * 3, [4.0, math.inf, 6.0]])
    cloud, _ = opened(tmp_path, pcd(points, encoding))
    np.testing.assert_array_equal(cloud.points, points.astype(np.float32))
    alone = np.full((5, 3), math.nan)
    cloud, _ = opened(tmp_path, pcd(alone, encoding))
    assert np.isnan(cloud.points).all()
    assert cloud.range_max == 0.0


def test_a_field_of_many_numbers_counts_as_many(tmp_path):
    header = (
        "VERSION .7\nFIELDS curve x rgb y z\nSIZE 4 4 1 8 4\nTYPE F F U F F\nCOUNT 3 1 4 1 1\n"
        "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
    )
    rows = [struct.pack("<3ff4Bdf", 9, 9, 9, k, 1, 2, 3, 4, k + 0.5, -k) for k in (1, 2)]
    expected = [[1, 1.5, -1], [2, 2.5, -2]]
    cloud, _ = opened(tmp_path, f"{header}binary\n".encode() + b"".join(rows))
    assert cloud.points.tolist() == expected
    columns = [
        struct.pack("<6f", *[9] * 6), struct.pack("<2f", 1, 2), bytes(8),
        struct.pack("<2d", 1.5, 2.5), struct.pack("<2f", -1, -2),
    ]  # fmt: skip
    plain = b"".join(columns)
    packed = lzf(plain)
    data = f"{header}binary_compressed\n".encode()
    cloud, _ = opened(tmp_path, data + struct.pack("<II", len(packed), len(plain)) + packed)
    assert cloud.points.tolist() == expected
    lines = "9 9 9 1 1 2 3 4 1.5 -1\n9 9 9 2 1 2 3 4 2.5 -2\n"
    cloud, _ = opened(tmp_path, f"{header}ascii\r\n{lines}".encode())
    assert cloud.points.tolist() == expected


def test_the_viewpoint_is_where_the_sensor_was(tmp_path):
    # at (10, 0, 2), turned by 90°: what lies at (10, 5, 2) is 5 m ahead of it
    half = math.sqrt(0.5)
    data = pcd(
        np.array([[10.0, 5.0, 2.0], [9.0, 0.0, 2.5]]),
        "binary",
        VIEWPOINT=f"10 0 2 {half} 0 0 {half}",
    )
    (tmp_path / "a.pcd").write_bytes(data)
    (frame,) = open_recording(tmp_path / "a.pcd")
    assert frame.observation.pose == pytest.approx([10.0, 0.0, math.pi / 2.0])
    expected = np.array([[5.0, 0.0, 0.0], [0.0, 1.0, 0.5]])
    assert frame.observation.clouds[0].points == pytest.approx(expected, abs=1e-6)
    (tmp_path / "a.pcd").write_bytes(pcd(np.ones((3, 3)), "ascii", VIEWPOINT="0 0 0 0 0 0 0"))
    recording = open_recording(tmp_path / "a.pcd")
    assert len(list(recording)) == 1
    assert "VIEWPOINT" in recording.warnings[0]


@pytest.mark.parametrize(
    "words",
    [
        {"POINTS": 10**12, "WIDTH": 10**12},
        {"WIDTH": -4, "POINTS": -4},
        {"WIDTH": "many"},
        {"WIDTH": None},
        {"SIZE": "4 4"},
        {"SIZE": "4 4 3"},
        {"SIZE": "-4 4 4"},
        {"COUNT": "1 1 -1"},
        {"TYPE": "F F X"},
        {"FIELDS": "x y w"},
        {"VIEWPOINT": "1 2"},
        {"FIELDS": None},
    ],
)
def test_a_header_is_never_trusted(tmp_path, words):
    (tmp_path / "a.pcd").write_bytes(pcd(np.ones((4, 3)), "binary", **words))
    with pytest.raises(RecordingError) as error:
        open_recording(tmp_path / "a.pcd")
    assert "a.pcd" in str(error.value)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_fewer_or_more_points_than_claimed_are_refused(tmp_path, rng, encoding):
    data = pcd(rng.uniform(1.0, 9.0, (50, 3)), encoding)
    claim = pcd(np.ones((4, 3)), encoding, WIDTH=19_000_000, POINTS=19_000_000)
    for wrong in (data[:-150], data + b"\xaa" * 37, claim):
        (tmp_path / "a.pcd").write_bytes(wrong)
        with pytest.raises(RecordingError, match=r"a\.pcd: .*instead of"):
            open_recording(tmp_path / "a.pcd")


@given(st.binary(max_size=600), st.integers(1, 40))
def test_lzf_undoes_what_it_compressed(some, times):
    data = some * times
    assert decompress_lzf(lzf(data), len(data)).tobytes() == data


@given(st.binary(max_size=300), st.integers(0, 10_000))
def test_lzf_of_anything_never_reads_or_writes_beyond(data, size):
    assert len(decompress_lzf(data, size)) <= size


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("tail", [bytes(1), bytes(4096), b"\r\n", b"\n" + bytes(100)])
def test_padding_after_the_points_is_no_damage(tmp_path, rng, encoding, tail):
    points = rng.uniform(1.0, 9.0, (50, 3))
    cloud, recording = opened(tmp_path, pcd(points, encoding) + tail)
    assert cloud.points == pytest.approx(points, abs=1e-5)
    assert recording.warnings == []
