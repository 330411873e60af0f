"""robsim's own controller along a path."""

from task import WAYPOINTS

import robsim

control = robsim.FollowPath(WAYPOINTS)
