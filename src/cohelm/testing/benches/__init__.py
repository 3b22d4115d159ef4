"""Benchmarks that need the oracles of ``cohelm.testing``."""
