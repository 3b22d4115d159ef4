"""Benchmark of perception: recordings, filmed crowds, invalid readings, cost."""
