"""Parts around the navigator: link, watchdog, limits, mission, world, and its own process."""
