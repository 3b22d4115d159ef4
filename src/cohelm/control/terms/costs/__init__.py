"""Cost terms ½‖r‖² of the optimal-control problem; one file each."""
