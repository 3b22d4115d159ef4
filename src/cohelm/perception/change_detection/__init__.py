"""Compare detections with earlier readings: a person has arrived where nothing was before."""
