"""The commands ``robsim tasks``: list, show and try tasks."""

from __future__ import annotations

from robsim.cli.command import Command, command_group
from robsim.cli.tasks import showing, trying

HELP = (
    "A task is a world, the callbacks that you write for it, and scores. Show one with --to "
    "to get its sheet and files to start from; edit them, and try them as often as you like: they "
    "are run beside a reference, in the same runs."
)
app = command_group("Start with: robsim tasks list")
app.command("list", cls=Command, epilog="Example: robsim tasks list")(showing.list_tasks)
app.command(cls=Command, help=showing.SHOW_HELP, epilog=showing.SHOW_EXAMPLE)(showing.show)
app.command("try", cls=Command, help=trying.HELP, epilog=trying.EXAMPLE)(trying.try_solution)
