"""Drawings of rides and routes: one figure, one file; readable in colour and in black and white."""

from cohelm.pictures.animate import animate_ride
from cohelm.pictures.canvas import check_picture
from cohelm.pictures.film import check_animation
from cohelm.pictures.plan import PlanRecord, draw_plan
from cohelm.pictures.proposed import draw_routes
from cohelm.pictures.ride import RideRecord, draw_ride
from cohelm.pictures.routes import RoutePanel, draw_error_plot, draw_route_panels

__all__ = [
    "PlanRecord",
    "RideRecord",
    "RoutePanel",
    "animate_ride",
    "check_animation",
    "check_picture",
    "draw_error_plot",
    "draw_plan",
    "draw_ride",
    "draw_route_panels",
    "draw_routes",
]
