"""What the worst file of each row of SECURITY.md takes: ``./run bench limits``."""
