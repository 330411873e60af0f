"""What every room stands on: checks of arguments, files, seeds, what ships."""
