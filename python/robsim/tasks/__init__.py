"""Tasks: what students are asked to do, and how a run of it is scored."""
