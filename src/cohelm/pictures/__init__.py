"""Drawings of rides, routes and people: one figure, one file; readable without colour, too."""

from cohelm.pictures.animate import animate_ride
from cohelm.pictures.canvas import check_picture
from cohelm.pictures.costs import CostPanel, draw_costs_against
from cohelm.pictures.film import check_animation
from cohelm.pictures.futures import Foretold, draw_futures
from cohelm.pictures.people import PeopleMoment, PeopleRecord, draw_people
from cohelm.pictures.people_film import animate_people
from cohelm.pictures.plan import PlanRecord, draw_plan
from cohelm.pictures.proposed import draw_routes
from cohelm.pictures.ride import RideRecord, draw_ride
from cohelm.pictures.routes import RoutePanel, draw_error_plot, draw_route_panels
from cohelm.pictures.scene import SceneRecord, draw_scene
from cohelm.pictures.strips import Strip, StripPanel, draw_strips

__all__ = [
    "CostPanel",
    "Foretold",
    "PeopleMoment",
    "PeopleRecord",
    "PlanRecord",
    "RideRecord",
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
    "draw_futures",
    "draw_people",
    "draw_plan",
    "draw_ride",
    "draw_route_panels",
    "draw_routes",
    "draw_scene",
    "draw_strips",
]
