"""The background: the image of the floor.

Called once, at the start. Gets the work area without the robot: an array (H, W, 3) of uint8, RGB,
one pixel per px of the work area. background[0, 0] is the top left corner.
Returns the changed array, of the same shape.
"""

ENABLED = True  # False: robsim's default instead of this file


def adjust_background(background):
    """Draw a red square near the top: vision must not mistake it for the robot's red marker."""
    left, top, side = 572, 64, 56  # px
    background[top : top + side, left : left + side] = (198, 36, 40)  # red, green, blue
    # To try: a blue square next to it. Is the robot still found?
    # background[64:120, 640:696] = (30, 70, 190)
    # To try: a black line across the area, 20 px wide.
    # background[590:610, :] = 0
    return background
