"""Check sensor clocks, and estimate ego motion from scans and clouds alone."""
