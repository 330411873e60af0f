"""What the frames of a camera take, from their bytes to the pose: ``./run bench camera``."""
