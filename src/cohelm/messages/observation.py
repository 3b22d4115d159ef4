"""The observation: pose, velocity, sensor readings and rider input at one instant."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.messages.people import People


@value
class Scan:
    """One sweep of a planar laser scanner, after sensor_msgs/LaserScan and REP-117."""

    time: float
    """Time of the sweep, s."""
    mount: Annotated[Floats, Shape("3")]
    """X_RL, the sensor on the robot."""
    angle_min: float
    """Direction of the first beam in the sensor's frame, rad."""
    angle_increment: float
    """From beam to beam, rad, counter-clockwise."""
    range_max: float
    """m."""
    ranges: Annotated[Floats, Shape("b")]
    """m; +inf: no return within range; NaN: a dropout."""


@value
class PointCloud:
    """One sweep of a 3-D LiDAR or one frame of a depth camera, after sensor_msgs/PointCloud2."""

    time: float
    """Time of the sweep, s."""
    mount: Annotated[Floats, Shape("6")]
    """X_RS, the sensor on the robot: x, y, z in m, then roll, pitch, yaw in rad about the fixed
    axes (REP-103); z is the height above the floor under the robot, NaN where unknown."""
    points: Annotated[Floats32, Shape("p 3")]
    """(x, y, z) in the sensor's frame, m; a row that is not finite is a beam without return."""
    range_max: float
    """Range of the sensor, m."""


@value
class RiderCommand:
    """Input of the rider's device. *Alive* and *deflected* are different things."""

    heartbeat: float
    """Time of the device's last message, s."""
    deflection: Annotated[Floats, Shape("2")]
    """(forward, left), each −1…1 of full deflection; (0, 0) is centred."""


@value
class Inertial:
    """Reading of an inertial unit over the drive axle, robot frame, after sensor_msgs/Imu."""

    time: float
    """s."""
    acceleration: Annotated[Floats, Shape("3")]
    """Specific force, m/s²: (0, 0, 9.81) at rest on level floor."""
    turn_rate: Annotated[Floats, Shape("3")]
    """rad/s."""
    tilt: Annotated[Floats, Shape("2")]
    """Roll and pitch, rad; pitch > 0 looks down (REP-103)."""


@value
class Observation:
    """Everything that the navigator knows of the world at one instant."""

    time: float
    """Now, s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR, as estimated by the localiser."""
    pose_time: float
    """Time of the localiser's last message, s."""
    twist: Annotated[Floats, Shape("3")]
    """Measured by odometry, robot frame."""
    twist_time: float
    """Time of the last odometry message, s."""
    pose_covariance: Annotated[Floats, Shape("3 3")] | None = None
    """Covariance of the pose as the localiser states it, m² and rad²; None: not stated."""
    command: Annotated[Floats, Shape("3")] | None = None
    """Twist that the motor controller was last told to follow; None: not known."""
    scans: tuple[Scan, ...] = ()
    """Scans that arrived since the last observation."""
    clouds: tuple[PointCloud, ...] = ()
    """Point clouds that arrived since the last observation."""
    rider: RiderCommand | None = None
    """None: no device."""
    people: People | None = None
    """People from an external source, which they name; None: detect them in scans and clouds."""
    inertial: Inertial | None = None
    """None: no inertial unit. It is recorded, and no part of cohelm uses it."""
    late: float = 0.0
    """Deadline overrun of this tick, s; 0 in simulation and replay unless injected."""

    @staticmethod
    def at_rest(
        time: float,
        *,
        pose: Floats | None = None,
        scans: tuple[Scan, ...] = (),
        clouds: tuple[PointCloud, ...] = (),
    ) -> Observation:
        """Return the observation of a robot at rest at ``pose`` (3,), X_MR; None: map origin."""
        return Observation(
            time=time,
            pose=np.zeros(3) if pose is None else pose,
            pose_time=time,
            twist=np.zeros(3),
            twist_time=time,
            scans=scans,
            clouds=clouds,
        )
