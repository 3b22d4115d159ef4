"""Benchmarks of others, ported to this simulator."""
