"""Packed values are restored to the bit."""

import json
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.messages import (
    Decision,
    Mode,
    Observation,
    People,
    PointCloud,
    Reason,
    Request,
    RiderCommand,
    RiderProfile,
    Scan,
    Wish,
)
from cohelm.recordings import RideTick
from cohelm.recordings.rides.exact import pack, unpack

ANY = st.floats(width=64)
"""NaN, infinities, −0.0 and denormals too."""


def rows(*shape):
    count = int(np.prod(shape))
    return st.lists(ANY, min_size=count, max_size=count).map(lambda n: np.array(n).reshape(shape))


SCANS = st.builds(
    Scan,
    time=ANY,
    mount=rows(3),
    angle_min=ANY,
    angle_increment=ANY,
    range_max=ANY,
    ranges=st.integers(0, 5).flatmap(rows),
)
CLOUDS = st.builds(
    PointCloud,
    time=ANY,
    mount=rows(6),
    points=st.integers(0, 4).flatmap(lambda p: rows(p, 3)).map(lambda a: np.nan_to_num(a) % 1e3),
    range_max=ANY,
)
CROWDS = st.integers(0, 3).flatmap(
    lambda n: st.builds(
        People,
        time=ANY,
        id=st.lists(st.integers(-(2**63), 2**63 - 1), min_size=n, max_size=n).map(np.array),
        mean=rows(n, 4),
        covariance=rows(n, 4, 4),
        heading=rows(n),
        radius=rows(n),
        confidence=rows(n),
        source=st.text(max_size=5),
    )
)
OBSERVATIONS = st.builds(
    Observation,
    time=ANY,
    pose=rows(3),
    pose_time=ANY,
    twist=rows(3),
    twist_time=ANY,
    scans=st.lists(SCANS, max_size=2).map(tuple),
    clouds=st.lists(CLOUDS, max_size=2).map(tuple),
    rider=st.none() | st.builds(RiderCommand, heartbeat=ANY, deflection=rows(2)),
    people=st.none() | CROWDS,
    late=ANY,
)


@given(OBSERVATIONS)
def test_an_observation_comes_back_to_the_bit(seen):
    assert identical(unpack(pack(seen), Observation), seen)


def a_tick():
    request = Request(
        goal=np.array([0.1, 0.2]),
        wishes=(
            Wish(points=np.array([[1.0, 2.0]])),
            Wish(kind="avoid", points=np.zeros((3, 2)), radius=0.3, hard=True),
        ),
        mode=Mode.ASSISTED,
        profile=RiderProfile(preferred_speed=0.1 + 0.2, passing_side="left"),
        stop=True,
    )
    decision = Decision(twist=np.array([0.1, -0.0, np.pi]), reason=Reason.TOO_CLOSE)
    seen = Observation.at_rest(1.0)
    return RideTick(number=7, observation=seen, request=request, decision=decision, digest="")


def test_requests_decisions_and_their_parameters_come_back():
    tick = a_tick()
    assert np.isinf(tick.request.speed_limit)
    assert identical(unpack(pack(tick), RideTick), tick)


def test_equal_values_give_equal_bytes():
    assert pack(a_tick()) == pack(a_tick())


def test_every_flipped_bit_is_noticed():
    data = pack(a_tick())
    for at in range(0, len(data), 7):
        broken = bytearray(data)
        broken[at] ^= 1 << (at % 8)
        with pytest.raises(ValueError, match=r"damaged|not a packed value"):
            unpack(bytes(broken), RideTick)


@pytest.mark.parametrize("length", [0, 3, 11, 12, 40, -1])
def test_what_is_cut_is_refused(length):
    with pytest.raises(ValueError, match=r"damaged|not a packed value"):
        unpack(pack(a_tick())[:length], RideTick)


def test_another_value_is_refused_by_its_name():
    with pytest.raises(ValueError, match="is not a Scan"):
        unpack(pack(a_tick()), Scan)


def sealed(tree, raw=b""):
    """Bytes laid out as the documentation says, made without cohelm."""
    text = json.dumps(tree).encode()
    text += b" " * (-(12 + len(text)) % 8)
    body = struct.pack("<I", len(text)) + text + raw
    return b"CHV1" + struct.pack("<I", zlib.crc32(body)) + body


def test_the_layout_is_the_one_that_is_documented():
    tree = {
        "twist": {"dtype": "<f8", "shape": [3], "at": 0},
        "reason": "too_close",
        "emergency": False,
    }
    raw = struct.pack("<3d", 0.25, 0.0, -1.5)
    decision = Decision(twist=np.array([0.25, 0.0, -1.5]), reason=Reason.TOO_CLOSE)
    assert identical(unpack(sealed(tree, raw), Decision), decision)
    # and what cohelm packs can be read so
    data = pack(decision)
    (length,) = struct.unpack_from("<I", data, 8)
    told = json.loads(data[12 : 12 + length])
    assert told["reason"] == "too_close"
    assert (12 + length) % 8 == 0
    at = 12 + length + told["twist"]["at"]
    assert struct.unpack_from("<3d", data, at) == (0.25, 0.0, -1.5)


@pytest.mark.parametrize(
    "tree",
    [
        [],
        None,
        {"twist": [0, 0, 0]},
        {"twist": {"dtype": "<f8", "shape": [3], "at": 8}},
        {"twist": {"dtype": "<f8", "shape": [-3], "at": 0}},
        {"twist": {"dtype": "O", "shape": [3], "at": 0}},
        {"twist": {"dtype": "<f8", "shape": [2], "at": 0}},
        {"twist": {"dtype": "<f8", "shape": [10**12], "at": 0}},
        {"twist": {"dtype": "<f8", "shape": [3], "at": 0}, "reason": "bored"},
        {"twist": {"dtype": "<f8", "shape": [3], "at": 0}, "surprise": 1},
    ],
)
def test_what_makes_no_sense_is_refused_though_its_checksum_agrees(tree):
    with pytest.raises(ValueError, match="is not a Decision"):
        unpack(sealed(tree, bytes(24)), Decision)
