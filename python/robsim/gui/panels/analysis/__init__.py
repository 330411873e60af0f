"""The results of a run: traces, statistics, past steps, estimates."""
