"""Drawings of rides, routes and people: one figure, one file; readable without colour, too."""

from cohelm.plotting.animation import check_animation
from cohelm.plotting.canvas import check_picture
from cohelm.plotting.charts import (
    CostPanel,
    Strip,
    StripPanel,
    draw_costs_against,
    draw_replay,
    draw_strips,
)
from cohelm.plotting.map import draw_map
from cohelm.plotting.people import PeopleMoment, PeopleRecord, draw_people
from cohelm.plotting.people_animation import animate_people
from cohelm.plotting.ride import DrawnRide, draw_ride
from cohelm.plotting.ride_animation import AnimationStyle, animate_ride
from cohelm.plotting.route_panels import RoutePanel, draw_error_plot, draw_route_panels
from cohelm.plotting.scene import PlanRecord, SceneRecord, draw_plan, draw_scene

__all__ = [
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
    "check_picture",
    "draw_costs_against",
    "draw_error_plot",
    "draw_map",
    "draw_people",
    "draw_plan",
    "draw_replay",
    "draw_ride",
    "draw_route_panels",
    "draw_scene",
    "draw_strips",
]
