"""The face: panels of a run in a notebook, or in a browser window of their own."""

__all__: list[str] = []
