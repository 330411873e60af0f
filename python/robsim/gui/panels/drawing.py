"""Figures of matplotlib for the panel: one at a time, since its settings belong to all threads."""

from __future__ import annotations

from threading import Lock

drawing = Lock()
