"""cohelm: shared control for wheelchairs among people."""
