"""Recorded pedestrian trajectories, and their replay as simulated pedestrians."""
