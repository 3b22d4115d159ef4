"""Benchmarks that anybody can repeat: scenes from seeds, outside references, honest tables."""
