"""The command ``robsim``, also as ``python -m robsim``."""

import io
import os
import sys


def main() -> None:
    """Run the command line; Ctrl-C during loading ends it with a short message, no traceback."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # it was closed, or there is no console
            setattr(sys, name, io.StringIO())
    try:
        os.getcwd()
    except FileNotFoundError:
        print("error: the current folder no longer exists", file=sys.stderr)
        sys.exit(2)
    try:
        from robsim.cli import main as run

        run()
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(130)
    except (ImportError, AttributeError) as error:
        from robsim.base.hidden_modules import check_modules

        check_modules(error)
        raise


if __name__ == "__main__":
    main()
