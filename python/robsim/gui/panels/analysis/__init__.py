"""What the run has brought: traces, statistics, past steps, estimates."""
