"""Commands of the laboratory: live runs, recorded sessions."""
