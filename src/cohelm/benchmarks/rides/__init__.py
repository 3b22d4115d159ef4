"""Benchmarks that compare planners, riders and modes over many rides."""
