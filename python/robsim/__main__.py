"""``python -m robsim`` is the command ``robsim``."""

from robsim.cli import main

main()
