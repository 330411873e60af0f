"""The code of the callbacks: where it stands, how it is edited."""
