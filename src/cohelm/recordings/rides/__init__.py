"""Recorded rides in MCAP files: write, read, and the exact values inside."""
