"""A camera on this machine: MJPEG over HTTP, with faults to order."""

import contextlib
import io
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from PIL import Image


def jpeg(pixels, quality=95):
    """Return an image as JPEG, colours at full resolution."""
    data = io.BytesIO()
    Image.fromarray(pixels).save(data, "JPEG", quality=quality, subsampling=0)
    return data.getvalue()


class MjpegServer:
    """Serves the parts of a script, each when it is told to.

    `parts` is an iterable of what is sent: bytes = an image; (image, length) = one whose
    Content-Length is said to be so, None = not said; a callable is called (a wait, a test's event).
    `answer` are bytes that are sent instead, or a function of the path and the headers that
    returns them, or None for the parts; `mute`: nothing is sent at all.
    """

    def __init__(self, parts=(), *, answer=None, is_mute=False):
        self.parts = parts
        self.requests = []
        self.released = threading.Event()
        outer = self

        class Handler(BaseHTTPRequestHandler):
            def log_message(self, *_):
                pass

            def do_GET(self):
                outer.requests.append(self.headers)
                with contextlib.suppress(OSError):  # the reader may go at any time
                    if is_mute:
                        outer.released.wait(300)
                        return
                    said = answer(self.path, self.headers) if callable(answer) else answer
                    if said is None:
                        outer.serve(self)
                    else:
                        self.wfile.write(said)

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,))
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}/video.mjpg"

    def serve(self, handler):
        kind = "multipart/x-mixed-replace; boundary=--frame"
        handler.wfile.write(f"HTTP/1.0 200 OK\r\nContent-Type: {kind}\r\n\r\n".encode())
        parts = self.parts() if callable(self.parts) else self.parts
        for part in parts:
            if callable(part):
                part()
                continue
            image, length = part if isinstance(part, tuple) else (part, len(part))
            said = "" if length is None else f"Content-Length: {length}\r\n"
            head = f"--frame\r\nContent-Type: image/jpeg\r\n{said}\r\n"
            handler.wfile.write(head.encode() + image + b"\r\n")

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self.released.set()
        self._server.shutdown()
        self._thread.join(300)
        self._server.server_close()
