"""Costmap layers, one module per kind of source."""
