"""The classes of all commands, and how their arguments and options are declared.

The docstring of a command is its --help: description, lines of arguments and options, example.
The lines are in the order of the signature, one for each parameter with a plain type::

    SOURCE: Video file, or folder of images.
    --colors FILE: Colour file. [default: that of robsim]
    --video/--no-video: Write the annotated video, too.

Options shared by several commands are `Annotated` types, declared by `option` and the like.
"""

from __future__ import annotations

import importlib
import inspect
import re
import typing
from collections.abc import Callable
from inspect import Parameter
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from robsim.base.text import quoted
from robsim.cli import errors


class Command(TyperCommand):
    """A command whose --help shows no types."""

    def get_params(self, ctx: Any) -> list[Any]:
        return _without_types(super().get_params(ctx))

    def invoke(self, ctx: Any) -> Any:
        """Run the command; errors become sentences, and name arguments as the shell does."""
        names: dict[str, str] = {}
        for one in self.params:
            shown = one.opts[0] if one.param_type_name == "option" else one.metavar or one.name
            names |= dict.fromkeys((one.name, one.opts[0].lstrip("-").replace("-", "_")), shown)
        with errors.names(names), errors.report_errors():
            return super().invoke(ctx)


class Group(TyperGroup):
    """Several commands; Ctrl-C ends each of them with a short message."""

    def get_params(self, ctx: Any) -> list[Any]:
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


class Later(TyperCommand):
    """A command, or a group of commands, whose module is loaded on first use.

    The module has a function of its name, or an `app` and HELP. A `bare` module handles calls with
    options of the page only, and loads faster.
    """

    def __init__(self, name: str, module: str, summary: str, bare: str | None = None) -> None:
        super().__init__(name, help=summary, rich_markup_mode="rich")
        self._module, self._bare = module, bare

    def loaded(self, *, is_bare: bool = False) -> Any:
        """Return the command itself."""
        name = self._bare if is_bare else self._module
        module: Any = importlib.import_module(f"robsim.cli.{name}")
        holder = typer.Typer(rich_markup_mode="rich", pretty_exceptions_enable=False)
        if hasattr(module, "app"):
            about = f"{self.help}\n\n{module.HELP}"
            holder.add_typer(module.app, name=self.name, cls=Group, help=about)
        else:
            command(holder, self.name, summary=self.help)(getattr(module, str(self.name)))
        return typer.main.get_group(holder).commands[str(self.name)]

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Begin to run the command itself."""
        is_bare = self._bare is not None and _OF_PAGE.fullmatch(" ".join(args)) is not None
        return self.loaded(is_bare=is_bare).make_context(info_name, args, parent, **extra)


_OF_PAGE = re.compile(r"((--no-browser|--port[ =]\d+)( |$))*")


def command_group(epilog: str) -> typer.Typer:
    """Return a group without commands."""
    return typer.Typer(no_args_is_help=True, rich_markup_mode="rich", epilog=epilog)


def command(
    app: typer.Typer, name: str | None = None, *, summary: str | None = None, **more: Any
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator that adds a command, described by its docstring, to a group.

    The last paragraph has a line for each parameter, ``--name VALUE: text [default: shown]``,
    unless the type is Annotated with that line. A `summary` replaces the first line of the
    docstring; `more` goes to Typer.
    """

    def add(function: Callable[..., None]) -> Callable[..., None]:
        signature = inspect.signature(function, eval_str=True)
        parameters = signature.parameters.values()
        first, *parts, example = (inspect.getdoc(function) or "").split("\n\n")
        has_plain = any(typing.get_origin(one.annotation) is not Annotated for one in parameters)
        entries = parts.pop().replace("\n    ", " ").split("\n") if has_plain else []
        known = [_declared(one, entries) for one in parameters]
        assert not entries, f"{function.__name__} has no parameter for {entries}"

        def shown(**given: Any) -> None:
            function(**given)

        shown.__signature__ = signature.replace(parameters=known)  # type: ignore[attr-defined]
        about = "\n\n".join([summary or first, *(part.replace("\n", " ") for part in parts)])
        called = name or function.__name__
        app.command(called, cls=Command, help=about, epilog=example, **more)(shown)
        return function

    return add


def _declared(parameter: Parameter, entries: list[str]) -> Parameter:
    """Return a parameter with the argument or option of its line, or of the first entry."""
    kind, entry = parameter.annotation, ""
    if typing.get_origin(kind) is Annotated:
        kind, entry = typing.get_args(kind)
    head, _, text = (entry or entries.pop(0)).partition(": ")
    name, _, value = head.partition(" ")
    text, _, default = text.partition(" [default: ")
    more: dict[str, Any] = {"show_default": default.removesuffix("]")} if default else {}
    for one, parse in _PARSERS.items():
        if one in (kind, *typing.get_args(kind)):
            more["parser"] = parse
    if name.startswith("-"):  # without a value --help shows nothing instead of a type
        made = typer.Option(name, metavar=value, help=text, **more)
    else:
        made = typer.Argument(metavar=name, help=text, **more)
    return parameter.replace(annotation=Annotated[kind, made])


def _without_types(params: list[Any]) -> list[Any]:
    """Return parameters without Python types in --help, such as <bool> of --help itself."""
    for param in params:
        if param.param_type_name == "argument" or param.name == "help":
            param.display_type_rich = lambda ctx: None
    return params


def whole_number(text: str) -> int:
    """Parse the text of an option that takes a whole number."""
    try:
        return int(text)
    except ValueError:
        limit = " of at most 4300 digits" if len(text) > 4300 else ""
        raise typer.BadParameter(f"it must be a whole number{limit}, got {quoted(text)}") from None


def number(text: str) -> float:
    """Parse the text of an option that takes a number."""
    try:
        return float(text)
    except ValueError:
        plain = re.match(r"-?\d+([.,]\d+)?", text.strip())
        meant = f"; did you mean {plain[0].replace(',', '.')}?" if plain else ""
        raise typer.BadParameter(
            f"it must be a number such as 0.5, got {quoted(text)}{meant}"
        ) from None


_PARSERS = {int: whole_number, float: number}
