"""How arguments and options of commands are declared: what --help shows of them."""

from __future__ import annotations

from typing import Any

import typer

from robsim.cli.text import number, whole_number


def argument(value: str, text: str, **more: Any) -> Any:
    """Return an argument that --help shows as `value`, with a text; `more` goes to Typer."""
    return typer.Argument(metavar=value, help=text, **more)


def option(name: str, value: str, text: str, **more: Any) -> Any:
    """Return an option whose value --help shows as `value`, with a text."""
    return typer.Option(name, metavar=value, help=text, **more)


def number_option(name: str, value: str, text: str, **more: Any) -> Any:
    """Return an option that takes a number."""
    return option(name, value, text, parser=number, **more)


def integer_option(name: str, value: str, text: str, **more: Any) -> Any:
    """Return an option that takes a whole number."""
    return option(name, value, text, parser=whole_number, **more)


def switch(name: str, text: str, **more: Any) -> Any:
    """Return an option without a value: in place of its type, --help shows nothing."""
    return option(name, "", text, **more)
