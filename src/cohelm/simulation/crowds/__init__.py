"""Pedestrian models."""

from cohelm.simulation.crowds.orca import Orca

__all__ = ["Orca"]
