"""A small sound file of each kind of recording, and what a reader makes of a file."""

import io

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer

from cohelm.messages import Observation
from cohelm.recordings import open_recording

from .bags import ROS1, ROS2, write
from .clouds import pcd

NAMES = [
    "ascii.pcd", "binary.pcd", "binary_compressed.pcd", "kitti.bin", "nuscenes.pcd.bin",
    "None.bag", "BZ2.bag", "LZ4.bag", "None.mcap", "STORAGE.mcap", "checked.mcap", "None.db3",
]  # fmt: skip


def everything(author):
    """A bag with all that is read."""
    still = (0.0, 0.0, 0.0)
    moved = author.transforms(
        (1.0, "map", "odom", still, still), (1.0, "odom", "base_link", still, still)
    )
    held = author.transforms(
        (0.0, "base_link", "laser", (0.3, 0.0, 0.2), still),
        (0.0, "base_link", "lidar", (0.0, 0.0, 1.0), still),
    )
    messages = [("/tf_static", 1.0, held), ("/tf", 1.0, moved)]
    for k in range(3):
        t = 1.0 + 0.1 * k
        messages += [
            ("/odom", t, author.odometry(t, (0.1 * k, 0.0, 0.0), (1.0, 0.0, 0.0))),
            ("/leg_cluster_positions", t, author.poses(0.0, [(1.0, 0.0)])),
            ("/scan", t, author.scan(t, [1.0, 2.0, 3.0])),
            ("/points", t, author.plain_cloud(t, [[1, 2, 3], [4, 5, 6]])),
        ]
    return messages


def sound_files(folder):
    """The bytes of a sound file of each kind, by its name."""
    points = np.arange(90.0).reshape(30, 3)
    files = {
        f"{encoding}.pcd": pcd(points, encoding, "xyzi")
        for encoding in ("ascii", "binary", "binary_compressed")
    }
    files["kitti.bin"] = np.tile(np.arange(4.0, dtype="<f4"), 30).tobytes()
    files["nuscenes.pcd.bin"] = np.tile(np.arange(5.0, dtype="<f4"), 30).tobytes()
    for compression in (None, "BZ2", "LZ4"):
        file = write(folder / f"{compression}.bag", everything(ROS1), "bag", compression)
        files[file.name] = file.read_bytes()
    for kind, compression in (("mcap", None), ("mcap", "STORAGE"), ("db3", None)):
        path = write(folder / f"{kind}{compression}", everything(ROS2), kind, compression)
        files[f"{compression}.{kind}"] = (path / f"{path.name}.{kind}").read_bytes()
    files["checked.mcap"] = with_checksums(files["None.mcap"])
    return files


def with_checksums(data):
    """An MCAP file with the same messages as ROS 2 and cohelm write it; rosbags omits checksums."""
    out = io.BytesIO()
    writer = Writer(out)
    writer.start(profile="ros2")
    channels = {}
    for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages(
        log_time_order=False
    ):
        if channel.topic not in channels:
            number = writer.register_schema(schema.name, "ros2msg", b"")
            channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
        writer.add_message(
            channels[channel.topic], message.log_time, message.data, message.publish_time
        )
    writer.finish()
    return out.getvalue()


def read_frames(file):
    """(observations, warnings) of a recording."""
    recording = open_recording(file)
    frames = [frame.observation for frame in recording]
    for seen in frames:
        assert isinstance(seen, Observation)
        assert np.isfinite([seen.time, *seen.pose, *seen.twist]).all()
    return frames, recording.warnings
