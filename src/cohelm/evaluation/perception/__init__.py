"""Perception scored on recordings and on crowds of which the truth is known."""
