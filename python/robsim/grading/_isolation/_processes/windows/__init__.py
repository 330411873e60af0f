"""Workers on Windows: each a fresh process in a job object of its own."""
