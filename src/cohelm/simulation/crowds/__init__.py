"""Pedestrian models."""

from cohelm.simulation.crowds.aggressive import Aggressive
from cohelm.simulation.crowds.distracted import Distracted
from cohelm.simulation.crowds.inattentive import Inattentive
from cohelm.simulation.crowds.moods import entered
from cohelm.simulation.crowds.orca import Orca
from cohelm.simulation.crowds.social_force import SocialForce

__all__ = ["Aggressive", "Distracted", "Inattentive", "Orca", "SocialForce", "entered"]
