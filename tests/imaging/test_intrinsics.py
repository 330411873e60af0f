"""A camera's intrinsics: its lens, there and back, as OpenCV has it."""

import numpy as np
import pytest

from refusals import INF, NAN, refuses
from robsim.vision import Intrinsics

SIZE = (1280, 960)
MATRIX = np.array([[1010.0, 0, 636.5], [0, 1000, 482.25], [0, 0, 1]])
LENSES = {
    "barrel": (-0.12, 0, 0, 0, 0),
    "pincushion": (0.2, 0.05, 0, 0, 0),
    "both": (-0.3, 0.12, 0.001, -0.002, -0.02),
    "skewed": (0.05, -0.02, 0.004, 0.003, 0.01),
    "none": (0.0, 0.0, 0.0, 0.0, 0.0),
}


def grid(size=SIZE, n=9):
    sides = (np.linspace(-0.5, side - 0.5, n) for side in size)
    return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("distortion", LENSES.values(), ids=LENSES)
def test_a_lens_distorts_as_that_of_opencv(distortion):
    cv2 = pytest.importorskip("cv2")
    rays = np.c_[(grid() - MATRIX[:2, 2]) / MATRIX.diagonal()[:2], np.ones(81)]
    expected, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), MATRIX, np.array(distortion))
    found = Intrinsics(MATRIX, distortion).distorted(grid())
    np.testing.assert_allclose(found, expected[:, 0], atol=1e-9)


NO_MATRIX = (
    *(np.eye(2), np.zeros((3, 3)), 2 * np.eye(3), np.diag([0, 1, 1]), np.diag([1, -1, 1])),
    *(MATRIX.T, MATRIX + np.eye(3, k=1), MATRIX + np.diag([INF, 0, 0])),
)


def test_what_is_no_lens():
    for matrix in NO_MATRIX:
        refuses("matrix", Intrinsics, matrix)
    for distortion in ((1, 2, 3, 4), np.zeros((1, 5)), (0, 0, 0, 0, NAN), (0, 0, 0, INF, 0)):
        refuses("distortion", Intrinsics, MATRIX, distortion)
    for call in (Intrinsics(MATRIX).ideal, Intrinsics(MATRIX).distorted):
        for pixels in ((1, 2, 3), (NAN, 1)):
            refuses("pixels", call, pixels)
