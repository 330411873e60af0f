"""The measurement of the panel: what is read back from the screen is what was sent."""

import io
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim.gui._bench import in_page
from robsim.gui._bench.barcode import BITS, stamped_picture
from robsim.gui._bench.figures import PanelBench, painted


def test_figures_are_of_the_frames_that_were_seen():
    done = {k: 100.0 * k for k in range(11)}
    seen = [(k, 100.0 * k + (20 if k < 10 else 70)) for k in range(11)] + [(999, 0.0)]
    page = painted("page", seen, done, span=2.0, busy=0.5)
    assert page.rate == 5.5
    assert page.latency_median == 20
    assert page.latency_p95 == pytest.approx(45)
    assert page.busy == 25
    assert page.per_frame == pytest.approx(1000 * 0.5 / 11)
    text = str(PanelBench(hosts=(page,), matplotlib=500.0))
    assert "page" in text
    assert "11.0" in text  # times as long with matplotlib


def test_nothing_painted_is_no_result():
    with pytest.raises(RuntimeError, match="the page painted no frames"):
        painted("page", [(1, 2.0)], {}, span=1.0, busy=0.0)


@pytest.mark.slow
def test_frames_are_painted_in_their_order(chromium, monkeypatch):
    found = {}

    def keep(host, seen, done, span, busy):
        found.update(seen=seen, done=done)
        return painted(host, seen, done, span, busy)

    monkeypatch.setattr(in_page, "painted", keep)
    monkeypatch.setattr(in_page, "_WARM_UP", 0.5)
    page = in_page.measure_in(chromium, 2.0)
    numbers = np.array([k for k, _ in found["seen"] if k in found["done"]])
    assert len(numbers) > 3
    assert (np.diff(numbers) > 0).all()
    assert page.latency_median > 0


def test_the_number_is_in_the_picture():
    frame = robsim.Frame(np.full((400, 400, 3), 90, np.uint8))
    jpeg = stamped_picture(SimpleNamespace(frame=frame, k=0b1011), 400)
    row = np.asarray(Image.open(io.BytesIO(jpeg)))[4, :, 0]
    bits = [row[round((bit + 0.5) * 8)] > 127 for bit in range(BITS)]
    assert bits == [True, True, False, True] + [False] * (BITS - 4)
