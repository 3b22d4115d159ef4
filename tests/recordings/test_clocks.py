"""Stamps on different clocks."""

import numpy as np
import pytest

from cohelm.recordings import open_recording

from .bags import ROS1, ROS2, write

LEVEL = (0.0, 0.0, 0.0)
START = 1.7e9
"""Time of reception of the first message, s."""


def ride(author=ROS2, scans=0.0, tf=0.0, odometry=0.0, rate=1.0, frame="laser", topic="/scan"):
    """0.5 m/s along x for 6 s; the stamps of each stream are ahead of reception by so many s."""
    static = author.transforms((0.0, "base_link", "laser", (0.1, 0.0, 0.2), LEVEL))
    messages = [("/tf_static", START, static)]
    for k in range(61):
        t = START + 0.1 * k
        received = START + 0.1 * k / rate
        moved = author.transforms((t + tf, "odom", "base_link", (0.05 * k, 0.0, 0.0), LEVEL))
        wheels = author.odometry(t + odometry, (0.05 * k, 0.0, 0.0), (0.5, 0.0, 0.0))
        scan = author.scan(t + scans, [1.0, 1.0, 2.0 + 0.05 * k, 1.0, 1.0], frame)
        messages += [("/tf", received, moved), ("/odom", received, wheels), (topic, received, scan)]
    return messages


def check_aligned(recording):
    """The pose of each scan is that of its instant."""
    frames = list(recording)
    assert len(frames) == 61
    for k, frame in enumerate(frames):
        seen = frame.observation
        assert seen.scans[0].ranges[2] == pytest.approx(2.0 + 0.05 * k)
        assert seen.pose[0] == pytest.approx(0.05 * k, abs=1e-3)
        assert seen.twist[0] == pytest.approx(0.5, abs=1e-3)


def about_clocks(recording):
    return [text for text in recording.warnings if "stamps of" in text]


@pytest.mark.parametrize(
    ("streams", "difference"),
    [
        ({"scans": 3484.0 - START}, "1699996516.0 s behind"),  # s since the sensor was switched on
        ({"tf": -START, "odometry": -START}, "1700000000.0 s behind"),
        ({"tf": -START}, "1700000000.0 s behind"),
        ({"scans": -111.7}, "111.7 s behind"),
        ({"scans": -3.0}, "3.0 s behind"),
        ({"scans": 3600.0}, "3600.0 s ahead"),
        ({"odometry": 40.0}, "40.0 s ahead"),
        ({"scans": -111.7, "rate": 1.1}, "111.7 s behind"),
    ],
    ids=str,
)
@pytest.mark.parametrize("author", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
def test_stamps_on_another_clock_are_aligned_and_the_difference_is_said(
    tmp_path, author, streams, difference
):
    kind = "bag" if author is ROS1 else "mcap"
    recording = open_recording(write(tmp_path / "a", ride(author, **streams), kind))
    check_aligned(recording)
    (text,) = about_clocks(recording)
    assert difference in text


@pytest.mark.parametrize(
    "streams",
    [
        {},
        {"scans": -0.2, "tf": -0.2, "odometry": -0.2},
        {"scans": -900.0, "tf": -900.0, "odometry": -900.0},  # a bag that was played and recorded
    ],
    ids=str,
)
def test_stamps_of_one_clock_stay_as_they_are(tmp_path, streams):
    recording = open_recording(write(tmp_path / "a", ride(**streams), "mcap"))
    check_aligned(recording)
    assert about_clocks(recording) == []
    first = next(iter(recording)).observation.time
    assert first == pytest.approx(START + streams.get("scans", 0.0))


def test_a_scan_without_a_stamp_is_on_the_clock_of_reception(tmp_path):
    messages = [
        (topic, received, ROS2.scan(0.0, message.ranges) if topic == "/scan" else message)
        for topic, received, message in ride(tf=-START, odometry=-START)
    ]
    check_aligned(open_recording(write(tmp_path / "a", messages, "mcap")))


def test_times_of_reception_that_vary_are_not_used(tmp_path):
    # The recorder stood still: all messages have one time of reception.
    messages = [(topic, START, message) for topic, _, message in ride(scans=-111.7)]
    recording = open_recording(write(tmp_path / "a", messages, "mcap"))
    assert len(list(recording)) == 61
    assert next(iter(recording)).observation.time == pytest.approx(START - 111.7)
    assert any("no pose of 'base_link' near" in text for text in recording.warnings)


def test_scanners_on_different_clocks_come_in_the_order_of_reception(tmp_path):
    messages = []
    for k in range(20):
        t = START + 0.1 * k
        messages += [
            ("/front", t, ROS2.scan(t, [1.0], "front")),
            ("/rear", t + 0.05, ROS2.scan(t + 0.05 - 500.0, [2.0], "rear")),
        ]
    recording = open_recording(write(tmp_path / "a", messages, "mcap"))
    frames = [frame.observation for frame in recording]
    assert [seen.scans[0].ranges[0] for seen in frames] == [1.0, 2.0] * 20
    assert np.diff([seen.time for seen in frames]) == pytest.approx(np.full(39, 0.05), abs=1e-5)
    (text,) = about_clocks(recording)
    assert "stamps of /rear are 500.0 s behind those of /front" in text
