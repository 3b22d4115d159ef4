"""The global planners and the steps that they share."""
