"""Measurement: the pose of the robot in the camera image.

Called at every step that has a frame. Gets `step`, of which you need:
    step.frame.image       the image: an array (H, W, 3) of uint8, RGB, read-only
    step.frame.plane_map   map from pixels to the work area: to_world((u, v)) gives (x, y) in px
    step.blobs             the blobs of each colour, the largest first: step.blobs["red"] and
                           step.blobs["blue"] are lists; a blob has .centroid (u, v) and .area,
                           in pixels of the frame
    step.colors            the colours that the blobs were found with
    step.markers           geometry of the markers: .distance from red to blue, .offset from their
                           midpoint forward to the robot's centre (px)
Returns a Measurement of x, y (px), heading (rad). None: the robot was not seen.
"""

import robsim

ENABLED = False  # True: this stage is on


def measure(step):
    """Find the red and the blue blob whose distance is that of the robot's markers."""
    # To try: the same by hand. Red is on the lab robot's right and blue on its left.
    # import numpy as np
    # for red_blob in step.blobs["red"]:
    #     for blue_blob in step.blobs["blue"]:
    #         red = step.frame.plane_map.to_world(red_blob.centroid)
    #         blue = step.frame.plane_map.to_world(blue_blob.centroid)
    #         distance = np.linalg.norm(red - blue)
    #         if abs(distance - step.markers.distance) < 0.08 * step.markers.distance:
    #             right_x, right_y = (red - blue) / distance
    #             forward = np.array((right_y, -right_x))
    #             x, y = (red + blue) / 2 + step.markers.offset * forward
    #             return robsim.Measurement((x, y, np.arctan2(-right_x, right_y)))
    # return None
    return robsim.locate(step.blobs, step.markers, image=step.frame, colors=step.colors)
