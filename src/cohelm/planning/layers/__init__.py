"""Costmap layers, one file each."""
