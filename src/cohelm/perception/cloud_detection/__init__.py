"""Detect people in the point clouds of 3-D sensors."""
