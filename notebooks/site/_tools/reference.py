"""Pages of the reference that are made from the program: public names, the command line."""

import importlib
import inspect
from pathlib import Path

import typer.main
from typer.cli import get_docs_for_click

import robsim
import robsim.cli

#: Rooms that users import from themselves.
APART = ("estimation.reference", "teach.gym")
#: The folder of the pages that autosummary writes, one for each name.
OBJECTS = Path("reference/api")


def pages():
    """Yield the place and the bytes of each page."""
    at_home = set()
    for name in (*robsim._WINGS, *APART):
        text, names = wing_page(f"robsim.{name}")
        at_home |= names
        yield Path(f"reference/{name}.rst"), text.encode()
    yield Path("reference/robsim.rst"), top_page(at_home).encode()
    yield Path("reference/errors.rst"), errors_page(at_home).encode()
    yield Path("reference/commands.md"), command_line().encode()


def heading(text, line):
    return f"{text}\n{line * len(text)}\n\n"


def table(names, toctree=f"   :toctree: {OBJECTS.name}\n"):
    rows = "".join(f"   ~{name}\n" for name in names)
    return f".. autosummary::\n{toctree}   :nosignatures:\n\n{rows}\n"


def full_name(home, name):
    """Return the name that users write: that at the top, if it is there."""
    is_top = name in robsim.__all__ and getattr(home, name) is getattr(robsim, name)
    return f"robsim.{name}" if is_top else f"{home.__name__}.{name}"


def wing_page(wing):
    """Return the page of a wing, a table for each of its rooms, and the names on it."""
    module = importlib.import_module(wing)
    text = heading(wing, "=") + inspect.getdoc(module) + "\n\n"
    rooms = [importlib.import_module(f"{wing}.{room}") for room in vars(module).get("_homes", ())]
    rooms = [room for room in rooms if room.__name__.removeprefix("robsim.") not in APART]
    listed = []
    for room in rooms if len(rooms) > 1 else [module]:
        names = [full_name(module, name) for name in room.__all__ if name in module.__all__]
        if room is not module:
            text += heading(room.__name__.rsplit(".")[-1].capitalize(), "-")
            text += inspect.getdoc(room) + "\n\n"
        text += table(names)
        listed += names
    return text, set(listed)


def top_page(at_home):
    """Return the page of the names at the top; most have their own page in a wing."""
    names = [f"robsim.{name}" for name in robsim.__all__ if name != "__version__"]
    text = heading("robsim", "=") + inspect.getdoc(robsim) + "\n\n"
    text += table([name for name in names if name in at_home], toctree="")
    return text + table([name for name in names if name not in at_home])


def errors_page(names):
    """Return the page of errors and warnings; each has its own page in a wing."""
    errors = [name for name in sorted(names) if is_error(name)]
    return heading("Errors and warnings", "=") + table(errors, toctree="")


def is_error(name):
    """Return whether a full name is one of an exception."""
    module, _, last = name.rpartition(".")
    value = getattr(importlib.import_module(module), last)
    return isinstance(value, type) and issubclass(value, Exception)


def command_line():
    """Return a page with the --help of each command."""
    group = typer.main.get_command(robsim.cli.app)
    context = typer.Context(group, info_name="robsim")
    text = "# The command line\n\n"
    for name, command in group.commands.items():
        loaded = command.loaded()
        text += get_docs_for_click(
            obj=loaded, ctx=context, indent=1, name=name, call_prefix="robsim"
        )
    return text
