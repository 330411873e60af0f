"""What it takes to read a camera live and to find the robot in its frames, for ``robsim bench``."""
