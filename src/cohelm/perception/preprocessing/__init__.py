"""Usable returns of scans and clouds, before any detection."""
