"""Estimate the motion of a sensor from its scans and clouds alone."""
