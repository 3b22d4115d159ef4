"""Small bags, written by rosbags."""

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

SCAN = "sensor_msgs/msg/LaserScan"
CLOUD = "sensor_msgs/msg/PointCloud2"
ODOMETRY = "nav_msgs/msg/Odometry"
POSES = "geometry_msgs/msg/PoseArray"
TF = "tf2_msgs/msg/TFMessage"

NOETIC = get_typestore(Stores.ROS1_NOETIC)
NOETIC.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
HUMBLE = get_typestore(Stores.ROS2_HUMBLE)


class Author:
    """Makes the messages of one version of ROS."""

    def __init__(self, version):
        self.store = NOETIC if version == 1 else HUMBLE
        self.version = version

    def make(self, kind, /, **fields):
        return self.store.types[kind.replace("/", "/msg/")](**fields)

    def bytes(self, message):
        name = message.__msgtype__
        if self.version == 1:
            return bytes(self.store.serialize_ros1(message, name))
        return bytes(self.store.serialize_cdr(message, name))

    def header(self, time, frame):
        nanoseconds = round(time * 1e9)
        stamp = self.make(
            "builtin_interfaces/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9
        )
        sequence = {"seq": 0} if self.version == 1 else {}
        return self.make("std_msgs/Header", stamp=stamp, frame_id=frame, **sequence)

    def scan(self, time, ranges, frame="laser", **changed):
        about = {
            "angle_min": -0.5, "angle_max": 0.5, "angle_increment": 0.25, "time_increment": 0.0,
            "scan_time": 0.1, "range_min": 0.1, "range_max": 10.0,
            "intensities": np.empty(0, np.float32),
        }  # fmt: skip
        return self.make(
            "sensor_msgs/LaserScan",
            header=self.header(time, frame),
            ranges=np.array(ranges, np.float32),
            **(about | changed),
        )

    def cloud(self, time, data, fields, frame="lidar", **changed):
        """``fields``: (name, offset, datatype)."""
        made = [
            self.make("sensor_msgs/PointField", name=n, offset=o, datatype=d, count=1)
            for n, o, d in fields
        ]
        data = np.frombuffer(bytes(data), np.uint8)
        about = {"height": 1, "is_bigendian": False, "row_step": len(data), "is_dense": True}
        return self.make(
            "sensor_msgs/PointCloud2",
            header=self.header(time, frame),
            fields=made,
            data=data,
            **(about | changed),
        )

    def plain_cloud(self, time, points, frame="lidar"):
        points = np.asarray(points, "<f4")
        fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7)]
        return self.cloud(time, points.tobytes(), fields, frame, width=len(points), point_step=12)

    def vector(self, x, y, z, kind="Vector3"):
        return self.make(f"geometry_msgs/{kind}", x=float(x), y=float(y), z=float(z))

    def turn(self, roll=0.0, pitch=0.0, yaw=0.0):
        """Quaternion of the turns about the fixed axes, in this order."""
        (a, b, c), (d, e, f) = (
            [fn(0.5 * angle) for angle in (roll, pitch, yaw)] for fn in (np.cos, np.sin)
        )
        return self.make(
            "geometry_msgs/Quaternion",
            w=a * b * c + d * e * f,
            x=d * b * c - a * e * f,
            y=a * e * c + d * b * f,
            z=a * b * f - d * e * c,
        )

    def pose(self, x, y, yaw=0.0):
        return self.make(
            "geometry_msgs/Pose",
            position=self.vector(x, y, 0.0, "Point"),
            orientation=self.turn(yaw=yaw),
        )

    def transforms(self, *entries):
        """(time, parent, child, (x, y, z), (roll, pitch, yaw))."""
        made = [
            self.make(
                "geometry_msgs/TransformStamped",
                header=self.header(time, parent),
                child_frame_id=child,
                transform=self.make(
                    "geometry_msgs/Transform",
                    translation=self.vector(*place),
                    rotation=self.turn(*turns),
                ),
            )
            for time, parent, child, place, turns in entries
        ]
        return self.make("tf2_msgs/TFMessage", transforms=made)

    def odometry(self, time, pose, twist, frames=("odom", "base_link")):
        still = np.zeros(36)
        return self.make(
            "nav_msgs/Odometry",
            header=self.header(time, frames[0]),
            child_frame_id=frames[1],
            pose=self.make(
                "geometry_msgs/PoseWithCovariance", pose=self.pose(*pose), covariance=still
            ),
            twist=self.make(
                "geometry_msgs/TwistWithCovariance",
                twist=self.make(
                    "geometry_msgs/Twist",
                    linear=self.vector(twist[0], twist[1], 0.0),
                    angular=self.vector(0.0, 0.0, twist[2]),
                ),
                covariance=still,
            ),
        )

    def poses(self, time, places, frame="laser"):
        return self.make(
            "geometry_msgs/PoseArray",
            header=self.header(time, frame),
            poses=[self.pose(*place) for place in places],
        )


ROS1, ROS2 = Author(1), Author(2)


def write(path, messages, kind="bag", compression=None):
    """A bag of (topic, received, message); returns what is to be opened.

    ``kind``: ``bag``, ``mcap`` or ``db3``. ``compression``: a format of ROS 1, a mode of ROS 2.
    """
    author = ROS1 if kind == "bag" else ROS2
    if kind == "bag":
        writer = rosbag1.Writer(path)
        if compression:
            writer.set_compression(getattr(rosbag1.Writer.CompressionFormat, compression))
    else:
        plugin = {"mcap": rosbag2.StoragePlugin.MCAP, "db3": rosbag2.StoragePlugin.SQLITE3}[kind]
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
        if compression:
            mode = getattr(rosbag2.CompressionMode, compression)
            writer.set_compression(mode, rosbag2.CompressionFormat.ZSTD)
    with writer:
        topics = {}
        for topic, received, message in messages:
            if topic not in topics:
                topics[topic] = writer.add_connection(
                    topic, message.__msgtype__, typestore=author.store
                )
            writer.write(topics[topic], round(received * 1e9), author.bytes(message))
    return path


def walk(author, count=5, frame="laser"):
    """Scans at 10 Hz whose middle beam grows by 0.1 m."""
    return [
        ("/scan", 100.0 + 0.1 * k, author.scan(50.0 + 0.1 * k, [1, 1, 2 + 0.1 * k, 1, 1], frame))
        for k in range(count)
    ]
