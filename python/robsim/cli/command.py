"""The classes of all commands: help without types of Python, errors in the words of the shell."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from robsim.cli import errors


class Command(TyperCommand):
    """A command that names its own options in errors."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters."""
        return _without_types(super().get_params(ctx))

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with errors.naming_options({str(p.name): _shown(p) for p in self.params}):
            return super().invoke(ctx)


class Group(TyperGroup):
    """Several commands; Ctrl-C ends each of them with a word."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters."""
        return _without_types(super().get_params(ctx))

    def invoke(self, ctx: Any) -> Any:
        """Run one of the commands."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            errors.print_note("stopped")
            raise typer.Exit(130) from None  # as a shell has it: 128 + SIGINT
        except OSError as error:
            if error.filename is not None or isinstance(error, BrokenPipeError):
                raise
            errors.print_error(f"the output cannot be written: {error.strerror}")
            raise typer.Exit(2) from None


def _without_types(params: list[Any]) -> list[Any]:
    """Return parameters that show no type of Python in --help, such as <bool> of --help itself."""
    for param in params:
        if param.param_type_name == "argument" or param.name == "help":
            param.display_type_rich = lambda ctx: None
    return params


def _shown(param: Any) -> str:
    """Return the name of a parameter as --help shows it."""
    return str(param.metavar) if param.param_type_name == "argument" else str(param.opts[0])
