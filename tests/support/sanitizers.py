"""Which sanitizers the tests run under: `./run sanitize` and `./run tsan` load them."""

import os

_LOADED = os.environ.get("LD_PRELOAD", "")
ADDRESS = "libasan" in _LOADED
THREAD = "libtsan" in _LOADED
