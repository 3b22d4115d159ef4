"""Messages as a robot sends them."""

import numpy as np

from cohelm.messages import Scan
from cohelm.recordings.rides import ros_messages as ros

LASER_TF = np.array([0.3, 0.0, 0.4, 0.0, 0.0, 0.0])


def transforms(time, *links):
    """A TFMessage of (parent, child, pose (6,))."""
    out = ros.transform(time, links[0][:2], np.array(links[0][2], dtype=float))
    for parent, child, pose in links[1:]:
        out.transforms += ros.transform(
            time, (parent, child), np.array(pose, dtype=float)
        ).transforms
    return out


def scan(time, frame="laser", ranges=(1.0, 2.0, 3.0)):
    sweep = Scan(
        time=time,
        mount=np.zeros(3),
        angle_min=-0.1,
        angle_increment=0.1,
        range_max=10.0,
        ranges=np.array(ranges, dtype=float),
    )
    return ros.scan(frame, sweep)


def odometry(time, pose=(1.0, 2.0, 0.5), twist=(0.4, 0.0, 0.2), frames=("odom", "base_link")):
    return ros.odometry(time, frames, np.array(pose, dtype=float), np.array(twist, dtype=float))
