"""The program ``robsim`` with a camera on the bus."""

import robsim
from bus_cameras import new_lab
from commands import command


def test_it_is_listed(start):
    start(new_lab())
    assert "Simulated camera" in command("cameras").stdout


def test_live_drives_the_robot(start, tmp_path):
    lab = new_lab()
    start(lab)
    words = ("live", "--camera", "firewire://", "--motors", f"udp:{lab.address}")
    words += ("--area", "{}x{}".format(*lab.area), "--steps", "60")
    words += ("--control", "go-to-point:240,180", "--max-voltage", "6", "--slew-rate", "100")
    words += ("--frame-timeout", "100", "--no-record", "--out", str(tmp_path))
    done = command(*words)
    assert done.exit_code == 0, done.stderr
    track = robsim.Trace.load(tmp_path / "trace.npz").pose_measured
    assert abs(track[-1, :2] - track[0, :2]).max() > 10
