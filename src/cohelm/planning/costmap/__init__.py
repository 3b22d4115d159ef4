"""Costmap in Nav2's cost values, combined from layers."""
