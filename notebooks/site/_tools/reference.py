"""Pages of the reference that are made from the program: public names, errors, commands."""

import importlib
import inspect
from pathlib import Path

import errors
import typer.main
from typer.cli import get_docs_for_click

import robsim
import robsim.cli

#: Rooms that users import from themselves.
APART = ("estimation.reference", "teach.gym")


def pages():
    """Yield the place and the bytes of each page."""
    found = {}
    for name in (*robsim._WINGS, *APART):
        text, objects = wing_page(importlib.import_module(f"robsim.{name}"))
        found |= objects
        yield Path(f"reference/{name}.rst"), text.encode()
    top = [f"robsim.{name}" for name in robsim.__all__ if name != "__version__"]
    text = page(robsim, "=") + table([name for name in top if name in found], has_pages=False)
    text += table([name for name in top if name not in found])
    yield Path("reference/robsim.rst"), text.encode()
    classes = {name: value for name, value in found.items() if isinstance(value, type)}
    raised = {name: value for name, value in classes.items() if issubclass(value, Exception)}
    yield Path("reference/errors.rst"), errors.page(raised).encode()
    yield Path("reference/commands.md"), command_line().encode()


def wing_page(wing):
    """Return the page of a wing, a table for each of its rooms; and its objects by full name."""
    rooms = [getattr(wing, name) for name in vars(wing).get("_homes", ())]
    rooms = [room for room in rooms if not room.__name__.endswith(APART)]
    text, objects = page(wing, "="), {}
    for room in rooms if len(rooms) > 1 else [wing]:
        of_room = {full_name(wing, name): getattr(wing, name) for name in room.__all__}
        text += "" if room is wing else page(room, "-")
        text += table(of_room)
        objects |= of_room
    return text, objects


def full_name(wing, name):
    """Return the name that users write: that at the top, if it is there."""
    is_top = name in robsim.__all__ and getattr(wing, name) is getattr(robsim, name)
    return f"robsim.{name}" if is_top else f"{wing.__name__}.{name}"


def page(module, line):
    """Return the heading of a module and its docstring."""
    name = module.__name__
    return f"{name}\n{line * len(name)}\n\n{inspect.getdoc(module)}\n\n"


def table(names, *, has_pages=True):
    """Return a table of names; if it has their pages, autosummary writes a page for each."""
    rows = "".join(f"   ~{name}\n" for name in names)
    toctree = "   :toctree: api\n" if has_pages else ""
    return f".. autosummary::\n{toctree}   :nosignatures:\n\n{rows}\n"


def command_line():
    """Return a page with the --help of each command."""
    group = typer.main.get_command(robsim.cli.app)
    options = {"ctx": typer.Context(group), "indent": 1, "call_prefix": "robsim"}
    commands = [
        get_docs_for_click(obj=command.loaded(), name=name, **options)
        for name, command in group.commands.items()
    ]
    return "# The command line\n\n" + "".join(commands)
