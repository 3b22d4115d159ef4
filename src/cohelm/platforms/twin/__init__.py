"""MuJoCo twin: the same scenarios with a chair that has wheels, casters, springs and motors.

    chair, motors           MJCF from a robot file, and its speed controller
    building, people        floor and walls from a grid, bodies that the crowd models move
    sensors, contacts       rays from the moving body; forces and energies
    model, twin_chair       all of it as one model; the chair that a simulated world advances
    platform, film          plugin ``twin``; films of rides on any platform

Only this package imports MuJoCo, and only when a platform is opened: ``docs/twin.md``.
"""

from cohelm.platforms.twin.film import VIEWS, check_film, film_ride
from cohelm.platforms.twin.platform import Twin, TwinPlatform, load_mujoco
from cohelm.platforms.twin.twin_chair import TwinChair

__all__ = [
    "VIEWS",
    "Twin",
    "TwinChair",
    "TwinPlatform",
    "check_film",
    "film_ride",
    "load_mujoco",
]
