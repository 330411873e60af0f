"""The basis of marks: limits calibrated from right solutions, and marks of wrong solutions."""
