"""Parameters of a ROS 2 robot: the part ``platform:`` of its file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from cohelm.config import Model


def _topic(given: str) -> str:
    if not given.startswith("/") or " " in given or given.endswith("/"):
        raise ValueError(f"a topic is written as /{given.strip('/ ') or 'scan'}")
    return given


Topic = Annotated[str, AfterValidator(_topic)]


class DdsParameters(Model):
    """Network of the node."""

    domain: int | None = Field(None, ge=0, le=232)
    """ROS domain; None: ROS_DOMAIN_ID, else 0."""
    interface: str | None = None
    """Network interface, as ``eth0`` or ``lo``; None: Cyclone's choice."""
    peers: tuple[str, ...] = ()
    """Addresses of other computers where multicast does not reach them."""
    distribution: Literal["humble", "jazzy"] = "jazzy"
    """For ``ros2 node list``: jazzy and later, or humble; messages are the same."""


class FrameNames(Model):
    """Names of the frames (REP-105)."""

    map: str | None = "map"
    """Frame of map and goals; None: no localiser, the odometry's frame is used."""
    odom: str = "odom"
    base: str = "base_link"


class StickParameters(Model):
    """Stick of the rider as sensor_msgs/Joy; its driver sends five messages a second or more.

    Such a driver repeats the last position for ever if the stick itself is gone. So the stick needs
    a page that drives, or a dead-man button.
    """

    topic: Topic = "/joy"
    forward_axis: int = Field(1, ge=0, le=63)
    left_axis: int = Field(0, ge=0, le=63)
    dead_man: int | None = Field(None, ge=0, le=63)
    """Button that must be held while driving; then the stick drives without a page. None: a page
    drives, and the stick is its device."""
    renew: float = Field(5.0, gt=0.2, le=60.0)
    """Maximum time for which a held button counts while no axis and no button changes, s; assumed,
    after the vigilance devices of trains."""
    confirm: int = Field(0, ge=0, le=63)
    """Button that confirms that the chair may move; with a dead-man button."""
    stop: int = Field(1, ge=0, le=63)
    """Button that stops the chair."""


class InputLimits(Model):
    """Ages from which an input counts as lost; the safety gate has limits of its own."""

    localiser: float = Field(0.25, gt=0.0, le=5.0)
    """Maximum time since the last transform from ``odom`` to ``map`` arrived, s."""
    people: float = Field(0.5, gt=0.0, le=5.0)
    """Maximum age of people from another node, and of scans beside them, s."""


class Ros2Parameters(Model):
    """Topics, frames and network of a robot; the defaults are those of Nav2."""

    name: str = Field("cohelm", pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")
    """Name of the node."""
    transport: Literal["dds", "rclpy"] = "dds"
    """Cyclone DDS without ROS, or ``rclpy`` of a ROS installation, in its environment."""
    dds: DdsParameters = DdsParameters()
    use_sim_time: bool = False
    """Take the time from ``/clock``."""
    frames: FrameNames = FrameNames()
    scans: tuple[Topic, ...] = ("/scan",)
    """sensor_msgs/LaserScan; each message of the first one begins a control step."""
    clouds: tuple[Topic, ...] = ()
    """sensor_msgs/PointCloud2."""
    odometry: Topic = "/odom"
    """nav_msgs/Odometry."""
    command: Topic = "/cmd_vel"
    """geometry_msgs/TwistStamped or Twist."""
    stamped: bool = True
    """Publish TwistStamped (Nav2 from Jazzy on); False: Twist."""
    map: Topic | None = None
    """nav_msgs/OccupancyGrid, taken once at the start; None: the file's ``map:``, or no map."""
    stick: StickParameters | None = None
    """Stick on a topic; None: the page's stick only."""
    people: Topic | None = None
    """people_msgs/People of another node, in place of cohelm's own detection; None: its own."""
    goal: Topic | None = "/goal_pose"
    """geometry_msgs/PoseStamped, as RViz sends them."""
    actions: bool = False
    """Serve Nav2's actions ``follow_path`` and ``compute_path_to_pose``; with transport rclpy."""
    displays: bool = True
    """Publish route, plan, people, spaces and diagnostics under ``/cohelm``."""
    limits: InputLimits = InputLimits()
    wait: float = Field(10.0, gt=0.0, le=120.0)
    """Time for all inputs to come when the platform is opened, s."""

    @property
    def inputs(self) -> tuple[tuple[str, Topic], ...]:
        """(kind, topic) of all inputs without which the chair does not move."""
        return (
            *(("scan", topic) for topic in self.scans),
            *(("cloud", topic) for topic in self.clouds),
            ("odometry", self.odometry),
            *(("stick", topic) for topic in self.page_sticks),
            *(("people", topic) for topic in [self.people] if topic is not None),
        )

    @property
    def leading(self) -> Topic:
        """Topic whose messages begin the control steps: the first of scans, else of clouds."""
        return (*self.scans, *self.clouds)[0]

    @property
    def page_sticks(self) -> tuple[Topic, ...]:
        """Topic of a stick that is a device of the page that drives."""
        stick = self.stick
        return () if stick is None or stick.dead_man is not None else (stick.topic,)

    @model_validator(mode="after")
    def _senses_something(self) -> Ros2Parameters:
        if not self.scans and not self.clouds:
            raise ValueError("name at least one topic in scans or clouds")
        if self.actions and self.transport != "rclpy":
            raise ValueError("actions need 'transport: rclpy'")
        return self
