"""Commands of a teacher's assignment: new, calibrate, check, pack."""
