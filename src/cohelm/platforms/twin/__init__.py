"""MuJoCo twin: the same scenarios with a chair that has wheels, casters, springs and motors.

    chair, motors           MJCF from a robot file, and its speed controller
    building, people        floor and walls from a grid, bodies that the crowd models move
    sensors, contacts       rays from the moving body; forces and energies
    model, twin_chair       all of it as one model; the chair that a simulated world advances
    platform, film          plugin ``twin``; films of rides on any platform

Only this package imports MuJoCo, and only when a platform is opened: ``docs/twin.md``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
