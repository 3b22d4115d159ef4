"""Replanning: causes, path switching, remaining path and wishes."""
