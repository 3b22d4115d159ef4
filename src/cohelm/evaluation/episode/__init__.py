"""One ride from start to outcome, and its record."""
