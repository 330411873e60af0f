"""Serves pictures that show their time: ``/usr/bin/python3 rtsp_server.py PORT CODING``.

It runs in the Python of the system, which alone has GStreamer, and ends with its input. A picture
has a cell for each bit of its time (ms, monotonic), white for 1, from left to right.
"""

import sys
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtspServer  # noqa: E402

WIDTH, HEIGHT, FPS, CELLS = 640, 480, 25, 32
LIVE = "is-live=true do-timestamp=true format=time"
SILENCE = b"\xd5" * (8000 // FPS)  # between two pictures
ENCODERS = {
    "h264": "x264enc tune=zerolatency bitrate=3000 key-int-max=25 ! rtph264pay name=pay0 pt=96 "
    f"appsrc name=sound {LIVE} caps=audio/x-alaw,rate=8000,channels=1 ! rtppcmapay name=pay1 pt=8",
    "mjpeg": "jpegenc ! rtpjpegpay name=pay0 pt=26",
}


class Factory(GstRtspServer.RTSPMediaFactory):
    """The camera of a coding."""

    def __init__(self, coding):
        super().__init__()
        self.coding = coding
        self.set_shared(True)

    def do_create_element(self, _):
        """Return the way of a picture to the network."""
        form = f"video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate={FPS}/1"
        return Gst.parse_launch(
            f"( appsrc name=source {LIVE} caps={form} ! "
            f"queue leaky=downstream max-size-buffers=1 ! {ENCODERS[self.coding]} )"
        )

    def do_configure(self, media):
        """Send pictures, and sound beside some, until the last client has gone."""
        source, sound = (media.get_element().get_by_name(name) for name in ("source", "sound"))

        def push():
            if sound is not None:
                sound.emit("push-buffer", Gst.Buffer.new_wrapped(SILENCE))
            return source.emit("push-buffer", picture()) == Gst.FlowReturn.OK

        pushing = GLib.timeout_add(1000 // FPS, push)
        media.connect("unprepared", lambda _: GLib.source_remove(pushing))


def picture():
    """Return the picture of now."""
    now = int(1000 * time.monotonic())
    row = b"".join(bytes([255 * (now >> k & 1)]) * (WIDTH // CELLS) for k in range(CELLS))
    return Gst.Buffer.new_wrapped(row * HEIGHT + b"\x80" * (WIDTH * HEIGHT // 2))


if __name__ == "__main__":
    Gst.init(None)
    server, loop = GstRtspServer.RTSPServer(), GLib.MainLoop()
    server.set_address("127.0.0.1")
    server.set_service(sys.argv[1])
    server.get_mount_points().add_factory("/camera", Factory(sys.argv[2]))
    if not server.attach(None):
        sys.exit(f"port {sys.argv[1]} is taken")
    GLib.io_add_watch(
        sys.stdin, GLib.PRIORITY_DEFAULT, GLib.IO_HUP | GLib.IO_IN, lambda *_: loop.quit()
    )
    print("ready", flush=True)
    loop.run()
