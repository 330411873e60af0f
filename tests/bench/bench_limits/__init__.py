"""Cost of the worst file of each row of SECURITY.md: ``./run bench limits``."""
