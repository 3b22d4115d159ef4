"""Nav2's cost values (nav2_costmap_2d/cost_values.hpp)."""

from __future__ import annotations

FREE = 0
"""Nothing near."""
MAX_GRADED = 252
"""The dearest cell that the robot's centre may still cross."""
INSCRIBED = 253
"""Nearer to an obstacle than the robot is wide; blocked, and so are the values above."""
LETHAL = 254
"""An obstacle."""
UNKNOWN = 255
"""Never seen."""
