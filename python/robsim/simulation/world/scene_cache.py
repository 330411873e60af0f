"""The scenes that were made last, shared by all simulations of the process."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock

from robsim._core import Scene


class SceneCache:
    """Keeps the scenes that were asked for last; the newest one always. Safe for threads.

    Parameters
    ----------
    maximum_size : int
        Memory of all scenes together (bytes).
    """

    def __init__(self, *, maximum_size: int) -> None:
        self.maximum_size = maximum_size
        self.forget()

    def forget(self) -> None:
        """Forget all scenes."""
        self._scenes: OrderedDict[Hashable, Scene] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable, make: Callable[[], Scene]) -> Scene:
        """Return the scene of a key; `make` is called if there is none."""
        with self._lock:
            scene = self._scenes.get(key)
            if scene is not None:
                self._scenes.move_to_end(key)
                return scene
        # Unlocked, as it takes long: two threads may make the same scene, and one of them is kept.
        made = make()
        with self._lock:
            scene = self._scenes.setdefault(key, made)
            while len(self._scenes) > 1 and self.size > self.maximum_size:
                self._scenes.popitem(last=False)
            return scene

    @property
    def size(self) -> int:
        """Memory of the scenes (bytes)."""
        return sum(scene.nbytes for scene in self._scenes.values())
