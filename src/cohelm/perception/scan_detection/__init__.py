"""Detect people in planar scans."""
