"""What goes in: what is wanted, and all that may be known."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Floats32, Integers, Shape, value
from cohelm.config import Model


class Mode(StrEnum):
    """Who steers. Not a planner: there is no planner called manual."""

    AUTONOMOUS = "autonomous"
    """The chair alone."""
    SHARED = "shared"
    """The reference blends the path and the rider's hand by η."""
    ASSISTED = "assisted"
    """The rider alone, behind the whole safety gate, separation included."""
    MANUAL = "manual"
    """The rider alone; the gate checks freshness, NaN and limits only, so it can collide."""


Side = Literal["left", "right", "none"]
"""On which to pass somebody, as the rider sees it; ``none``: as it comes."""


class RiderProfile(Model):
    """What this rider likes, as the introduction of Xu et al. asks for; the values are assumed."""

    preferred_speed: float = Field(0.8, gt=0.0, le=3.0)
    """Cruising speed, m/s; bounded by the robot's limit."""
    clearance: float = Field(0.05, ge=0.0, le=1.0)
    """Distance kept from walls beyond the footprint, m."""
    social_distance: float = Field(0.45, ge=0.0, le=2.0)
    """Least reach of a person's social space, m (Hall's intimate distance)."""
    passing_side: Side = "none"
    """Side on which to pass a person, where both are as good."""
    tremor_filter: float = Field(0.0, ge=0.0, le=1.0)
    """Time constant of the low-pass on the stick, s; 0 is off."""
    dead_zone: float = Field(0.05, ge=0.0, lt=1.0)
    """Deflection below which the stick counts as centred, share of full deflection."""


@value
class Wish:
    """Where the rider wants the route to go, or not to.

    The points of one wish are passed in their order; wishes among themselves in whatever order is
    best.
    """

    kind: Literal["attract", "avoid", "stroke"] = "attract"
    """``attract``: pass near each point; ``stroke``: follow the line; ``avoid``: keep out of the
    zone: about a point or a line of two as far as ``radius``, or within a drawn outline of three
    points and more, and as far beyond."""
    points: Annotated[Floats, Shape("k 2")]
    """(x, y), m."""
    radius: float = 0.0
    """Reach of an avoided zone beyond its points, m."""
    hard: bool = False
    """Of an avoided zone: never enter it, even if no way is left; else only rather not."""


@value
class Request:
    """What is wanted; may change in mid-ride."""

    goal: Annotated[Floats, Shape("2")]
    """(x, y), m; NaN: nowhere, so that only the rider alone can move the chair."""
    wishes: tuple[Wish, ...] = ()
    mode: Mode = Mode.SHARED
    profile: RiderProfile = RiderProfile()
    speed_limit: float = np.inf
    """m/s."""
    stop: bool = False
    """The STOP control is pressed."""
    farther: float = 0.0
    """By how much more than the gate's own margin people are to be kept away, m."""


@value
class Scan:
    """One sweep of a planar laser scanner, after sensor_msgs/LaserScan and REP-117."""

    time: float
    """When it was taken, s."""
    mount: Annotated[Floats, Shape("3")]
    """X_RL, the sensor on the robot."""
    angle_min: float
    """Direction of the first beam in the sensor's frame, rad."""
    angle_increment: float
    """From beam to beam, rad, counter-clockwise."""
    range_max: float
    """m."""
    ranges: Annotated[Floats, Shape("b")]
    """m; +inf: nothing within reach; NaN: a dropout."""


@value
class PointCloud:
    """One sweep of a 3-D LiDAR or one frame of a depth camera, after sensor_msgs/PointCloud2."""

    time: float
    """When it was taken, s."""
    mount: Annotated[Floats, Shape("6")]
    """X_RS, the sensor on the robot: x, y, z in m, then roll, pitch, yaw in rad about the fixed
    axes (REP-103); z is the height above the floor under the robot, NaN where nobody knows."""
    points: Annotated[Floats32, Shape("p 3")]
    """(x, y, z) in the sensor's frame, m; a row that is not finite met nothing."""
    range_max: float
    """Reach of the sensor, m."""


@value
class RiderCommand:
    """The rider's device. *Alive* and *deflected* are different things."""

    heartbeat: float
    """When the device was last heard, s."""
    deflection: Annotated[Floats, Shape("2")]
    """(forward, left), each −1…1 of full deflection; (0, 0) is centred."""


@value
class People:
    """Who is there, as a struct of arrays; nobody is n = 0."""

    time: float
    """s."""
    id: Annotated[Integers, Shape("n")]
    """Stable over a person's life in view."""
    mean: Annotated[Floats, Shape("n 4")]
    """(x, y, v_x, v_y), m and m/s."""
    covariance: Annotated[Floats, Shape("n 4 4")]
    heading: Annotated[Floats, Shape("n")]
    """Direction faced, rad; NaN where unknown; kept from the last walk by those at rest."""
    radius: Annotated[Floats, Shape("n")]
    """Of the body's disc, m."""
    confidence: Annotated[Floats, Shape("n")]
    """0…1."""
    source: str = "tracker"
    """``tracker``: from the sensors; anything else came from outside and labels the results."""

    @staticmethod
    def nobody(time: float, source: str = "tracker") -> People:
        """No one at ``time``."""
        none = np.empty(0)
        return People(
            time=time,
            id=np.empty(0, dtype=np.int64),
            mean=none.reshape(0, 4),
            covariance=none.reshape(0, 4, 4),
            heading=none,
            radius=none,
            confidence=none,
            source=source,
        )

    def __len__(self) -> int:
        """How many people."""
        return len(self.id)


@value
class Observation:
    """All that the navigator may ever know of the world at one instant."""

    time: float
    """Now, s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR, as a localiser gives it."""
    pose_time: float
    """When the localiser last spoke, s."""
    twist: Annotated[Floats, Shape("3")]
    """As odometry measures it, robot frame."""
    twist_time: float
    """When odometry last spoke, s."""
    scans: tuple[Scan, ...] = ()
    """Those that arrived since the last observation."""
    clouds: tuple[PointCloud, ...] = ()
    """The same of 3-D sensors."""
    rider: RiderCommand | None = None
    """None: no device."""
    people: People | None = None
    """People given from outside, with their source named; None: see for yourself."""
    late: float = 0.0
    """By how much this tick missed its deadline, s; 0 in simulation and replay unless injected."""

    @staticmethod
    def at_rest(
        time: float,
        *,
        pose: Floats | None = None,
        scans: tuple[Scan, ...] = (),
        clouds: tuple[PointCloud, ...] = (),
    ) -> Observation:
        """Of a robot that stands still at ``pose`` (3,), X_MR; None: at the map's origin."""
        return Observation(
            time=time,
            pose=np.zeros(3) if pose is None else pose,
            pose_time=time,
            twist=np.zeros(3),
            twist_time=time,
            scans=scans,
            clouds=clouds,
        )
