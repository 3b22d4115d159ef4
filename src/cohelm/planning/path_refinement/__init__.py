"""Refinement of a grid path into a smooth line that the footprint can follow."""
