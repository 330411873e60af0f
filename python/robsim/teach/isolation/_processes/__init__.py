"""How processes of workers come to be, and how they and what they leave are ended."""
