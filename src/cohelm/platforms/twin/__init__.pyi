from .film import VIEWS, check_film, film_ride
from .platform import Twin, TwinPlatform, load_mujoco
from .twin_chair import TwinChair

__all__ = [
    "VIEWS",
    "Twin",
    "TwinChair",
    "TwinPlatform",
    "check_film",
    "film_ride",
    "load_mujoco",
]
