"""Track people over time, or pass on people that an external source reports."""
