"""What marks rest on: limits calibrated from right solutions, and what wrong ones come to."""
