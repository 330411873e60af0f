import numpy as np
import pytest
from matplotlib.colors import to_rgb

import robsim
from robsim.plotting import draw_overlay
from robsim.plotting import style as style
from sizes import thorough

GREY = 120
OUTLINE = [(50, 50), (50, -50), (-50, -50), (-50, 50)]


def make_frame(width=1200, height=1200, plane_map=None):
    pixels = np.full((height, width, 3), GREY, dtype=np.uint8)
    return robsim.Frame(pixels, plane_map=plane_map or robsim.vision.PlaneMap())


def has_color(pixels, color, place, reach=2, tolerance=40):
    """Whether there is the colour near a place (u, v)."""
    u, v = np.rint(place).astype(int)
    near = pixels[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
    difference = np.abs(near - 255 * np.array(to_rgb(color))).max(axis=2)
    return bool((difference < tolerance).any())


def changed(pixels):
    return np.argwhere((pixels != GREY).any(axis=2))[:, ::-1]  # (u, v)


def test_the_frame_stays_as_it_is():
    frame = make_frame()
    pixels = draw_overlay(frame)
    np.testing.assert_array_equal(pixels, frame.image)
    assert pixels.dtype == np.uint8
    assert pixels.flags.writeable
    assert pixels.flags.c_contiguous
    draw_overlay(frame, measurement=robsim.Measurement((600, 600, 0)), text="k 1")
    assert (frame.image == GREY).all()


@pytest.mark.parametrize("heading", np.deg2rad([0, 90, -160]))
def test_measurement_is_a_green_line_of_80_px_along_the_heading(heading):
    pixels = draw_overlay(make_frame(), measurement=robsim.Measurement((600, 500, heading)))
    forward = np.array((np.cos(heading), np.sin(heading)))
    for distance in (1, 40, 79):
        assert has_color(pixels, style.MEASURED, (600, 500) + distance * forward)
    for distance in (-10, 90):
        assert not has_color(pixels, style.MEASURED, (600, 500) + distance * forward)


def test_outline_stands_at_the_measured_pose():
    outline = [(50, 0), (0, 30), (0, -30)]  # the tip is ahead
    measurement = robsim.Measurement((600, 500, np.pi / 2))  # downwards on the picture
    pixels = draw_overlay(make_frame(), measurement=measurement, outline=outline)
    for corner in ((600, 550), (570, 500), (630, 500)):  # right of the robot = left here
        assert has_color(pixels, style.MEASURED, corner)
    assert not has_color(pixels, style.MEASURED, (600, 450))


def test_estimate_is_blue():
    estimate = robsim.Estimate((300, 400, 0.0), np.eye(3))
    pixels = draw_overlay(make_frame(), estimate=estimate, outline=OUTLINE)
    for place in ((309, 409), (291, 391), (309, 391), (291, 409), (375, 400), (350, 430)):
        assert has_color(pixels, style.ESTIMATED, place)
    assert not has_color(pixels, style.MEASURED, (350, 430), reach=5)


def test_blobs_have_their_boxes_outside_of_their_pixels():
    pixels = np.full((100, 100, 3), GREY, dtype=np.uint8)
    pixels[40:60, 30:45] = (200, 20, 20)
    blobs = robsim.find_blobs(pixels, robsim.load_colors())
    assert [blob.bounding_box for blob in blobs["red"]] == [(30, 40, 44, 59)]
    drawn = draw_overlay(
        robsim.Frame(pixels), blobs=blobs, measurement=robsim.Measurement((5, 5, 0))
    )
    for place in ((29.5, 50), (44.5, 50), (37, 39.5), (37, 59.5)):
        assert has_color(drawn, "red", place, reach=1, tolerance=100)
    np.testing.assert_array_equal(drawn[42:58, 32:43], pixels[42:58, 32:43])


def test_path_is_broken_where_nothing_was_seen():
    path = [(100, 300), (200, 300), (300, 300), (np.nan, np.nan), (500, 300), (600, 300)]
    pixels = draw_overlay(make_frame(), path=path)
    for u in (100, 150, 250, 300, 500, 550, 600):
        assert has_color(pixels, style.MEASURED, (u, 300))
    assert len(changed(pixels[:, 310:490])) == 0


def test_a_path_of_nothing():
    for path in (np.empty((0, 2)), [(np.nan, np.nan)], [(5, 5)]):
        assert len(changed(draw_overlay(make_frame(), path=path))) <= 4
    with pytest.raises(ValueError, match="path"):
        draw_overlay(make_frame(), path=np.zeros((2, 3)))


def test_not_seen():
    for measurement, blobs, is_told in (
        (None, {}, True),
        (None, None, False),
        (robsim.Measurement((600, 600, 0)), {}, False),
    ):
        pixels = draw_overlay(make_frame(), measurement=measurement, blobs=blobs)
        assert has_color(pixels, style.WRONG, (20, 20), reach=10) is is_told


@pytest.mark.parametrize("size", [(1200, 1200), (400, 300), (16, 16)])
def test_text_stands_at_the_bottom_and_fits(size):
    text = "k 57   t 11.4 s   x 612.3   y 401.0   heading 87.2 deg"
    pixels = draw_overlay(make_frame(*size), text=text, blobs={})
    bar = np.argwhere((pixels == round(0.35 * GREY)).all(axis=2))
    assert bar[:, 0].max() == size[1] - 1
    if size[0] >= 400:  # in a very small frame it is cut off
        light = np.argwhere((pixels[size[1] // 2 :] > 200).all(axis=2))
        assert len(light) > 50
        assert light[:, 1].max() < size[0] - 2
        assert np.ptp(light[:, 0]) >= 6


CAMERA = [[300, 0, 199.5], [0, 300, 149.5], [0, 0, 1]]


@pytest.mark.parametrize("distortion", [None, (-0.2, 0, 0, 0, 0)])
def test_places_go_through_the_plane_map(distortion):
    # a camera of 400 x 300 px, at an angle
    lens = distortion and robsim.vision.Intrinsics(CAMERA, distortion)
    plane_map = robsim.vision.PlaneMap([[3, 0.4, -60], [0, 4, 20], [0, 0.001, 1]], lens)
    measurement = robsim.Measurement((500, 500, 0.3))
    pixels = draw_overlay(
        make_frame(400, 300, plane_map),
        measurement=measurement,
        outline=OUTLINE,
        path=[(100, 800), (400, 800)],
    )
    ahead = (500 + 40 * np.cos(0.3), 500 + 40 * np.sin(0.3))
    assert has_color(pixels, style.MEASURED, plane_map.to_pixel(ahead), tolerance=100)
    assert has_color(pixels, style.MEASURED, plane_map.to_pixel((250, 800)))


@pytest.mark.long
def test_what_lies_outside_of_the_frame_is_cut_off(rng):
    for x, y in rng.uniform(-200, 1400, (thorough(100, 25), 2)):
        pixels = draw_overlay(
            make_frame(),
            measurement=robsim.Measurement((x, y, x)),
            estimate=robsim.Estimate((y, x, y), np.eye(3)),
            outline=OUTLINE,
        )
        assert pixels.shape == (1200, 1200, 3)
    for place in ((5000, 5000), (1e9, 400), (1e300, -1e300), (-5000, 0)):
        estimate = robsim.Estimate((*place, 0.0), np.eye(3))
        assert len(changed(draw_overlay(make_frame(), estimate=estimate, outline=OUTLINE))) == 0
