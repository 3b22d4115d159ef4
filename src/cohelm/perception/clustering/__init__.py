"""Clusters of points in the plane: DBSCAN, bounding ellipses, and fits of shapes."""
