"""The floor about the chair: where wheels can go, and where they would drop or be stopped."""
