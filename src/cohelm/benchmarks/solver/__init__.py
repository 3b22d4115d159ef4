"""Benchmark of the local planner's solver beside oracles of ``cohelm.testing``."""
