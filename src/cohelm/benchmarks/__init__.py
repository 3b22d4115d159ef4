"""Benchmarks of ``cohelm bench``: tasks, references, claims and reports."""
