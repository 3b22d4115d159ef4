"""Map live obstacles that are neither in the static map nor people."""
