"""What can be set while a run goes on."""
