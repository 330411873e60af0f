"""The kinds of tasks, each a dataclass."""
