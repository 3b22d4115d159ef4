"""Benchmarks and data of other authors: BARN, CrowdNav, filmed crowds."""
