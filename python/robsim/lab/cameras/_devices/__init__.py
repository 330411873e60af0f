"""What cameras are read with: a module for each kind."""
