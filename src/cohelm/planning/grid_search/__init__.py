"""Exact, compiled searches over a grid of weights."""
