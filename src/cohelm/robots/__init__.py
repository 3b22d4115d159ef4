"""Robots: kinematics, footprint, limits and sensor mounts."""

from cohelm.robots.kinematics import Kinematics, Unicycle, move
from cohelm.robots.robot import LaserMount, Robot, load_robot, robot_names

__all__ = ["Kinematics", "LaserMount", "Robot", "Unicycle", "load_robot", "move", "robot_names"]
