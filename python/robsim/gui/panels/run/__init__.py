"""The run: what moves it on, what can be set, what the camera sees."""
