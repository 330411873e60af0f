"""What is outside: frames that come, inputs that go."""
