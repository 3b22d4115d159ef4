"""Predict the motion of people."""
