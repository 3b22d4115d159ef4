"""Detect groups of people."""
