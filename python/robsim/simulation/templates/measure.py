"""Measurement: the pose of the robot in the camera image.

Called at every step that has a frame. Gets `step`. You need:
    step.frame.image       the image: an array (H, W, 3) of uint8, RGB, read-only
    step.frame.plane_map   map from pixels to the work area: to_world((u, v)) gives (x, y) in px
    step.blobs             the blobs of each colour, the largest first: step.blobs["red"] and
                           step.blobs["blue"] are lists; a blob has .centroid (u, v) and .area,
                           in pixels of the frame
    step.colors            the colours used to find the blobs
    step.markers           the markers: .colors by role, {"right": "red", "left": "blue"} of the
                           lab robot; .distance between them, .offset from their midpoint forward
                           to the robot's centre (px)
Returns a Measurement of x, y (px), heading (rad). None: the robot was not seen.
"""

import robsim

ENABLED = False  # True: this stage is on


def measure(step):
    """Find the two blobs at the distance of the robot's markers."""
    # To try: the same by hand, for a robot with a marker on its right and one on its left.
    # import numpy as np
    # for right_blob in step.blobs[step.markers.colors["right"]]:
    #     for left_blob in step.blobs[step.markers.colors["left"]]:
    #         right = step.frame.plane_map.to_world(right_blob.centroid)
    #         left = step.frame.plane_map.to_world(left_blob.centroid)
    #         distance = np.linalg.norm(right - left)
    #         if abs(distance - step.markers.distance) < 0.08 * step.markers.distance:
    #             right_x, right_y = (right - left) / distance
    #             forward = np.array((right_y, -right_x))
    #             x, y = (right + left) / 2 + step.markers.offset * forward
    #             return robsim.Measurement((x, y, np.arctan2(-right_x, right_y)))
    # return None
    return robsim.locate(step.blobs, step.markers, image=step.frame, colors=step.colors)
