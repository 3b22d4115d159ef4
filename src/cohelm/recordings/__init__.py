"""Recordings: bags and clouds in, observations out."""

from cohelm.recordings.api import Frame, Labels, Recording

__all__ = ["Frame", "Labels", "Recording"]
