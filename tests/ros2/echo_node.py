"""A plain rclpy node over Fast DDS that sends back every message: /NAME goes to /echo/NAME.

python -m tests.ros2.echo_node
"""

import rclpy
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy, LaserScan, PointCloud2
from std_msgs.msg import Float64

KINDS = (
    Clock, Float64, Joy, LaserScan, OccupancyGrid, Odometry, Path, PointCloud2, PoseStamped, Twist,
    TwistStamped,
)  # fmt: skip
RELIABLE = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


def main():
    rclpy.init()
    node = rclpy.create_node("echo")
    for kind in KINDS:
        name = kind.__name__.lower()
        back = node.create_publisher(kind, f"/echo/{name}", RELIABLE)
        node.create_subscription(kind, f"/{name}", back.publish, RELIABLE)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
