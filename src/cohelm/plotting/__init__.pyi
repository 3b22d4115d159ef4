from .animation import check_animation
from .canvas import check_folder, check_picture
from .charts import (
    CostPanel,
    Strip,
    StripPanel,
    draw_costs_against,
    draw_replay,
    draw_strips,
)
from .ground import draw_ground
from .map import draw_map
from .people import PeopleMoment, PeopleRecord, draw_people
from .people_animation import animate_people
from .ride import DrawnRide, draw_ride
from .ride_animation import AnimationStyle, animate_ride
from .route_panels import RoutePanel, draw_error_plot, draw_route_panels
from .scene import PlanRecord, SceneRecord, draw_plan, draw_scene
from .storey import AccessMarks, draw_storey, storey_svg

__all__ = [
    "AccessMarks",
    "AnimationStyle",
    "CostPanel",
    "DrawnRide",
    "PeopleMoment",
    "PeopleRecord",
    "PlanRecord",
    "RoutePanel",
    "SceneRecord",
    "Strip",
    "StripPanel",
    "animate_people",
    "animate_ride",
    "check_animation",
    "check_folder",
    "check_picture",
    "draw_costs_against",
    "draw_error_plot",
    "draw_ground",
    "draw_map",
    "draw_people",
    "draw_plan",
    "draw_replay",
    "draw_ride",
    "draw_route_panels",
    "draw_scene",
    "draw_storey",
    "draw_strips",
    "storey_svg",
]
