"""The commands ``robsim assignment``."""

from __future__ import annotations

from robsim.cli.assignment import calibrate, check, new, pack
from robsim.cli.command import Command, command_group

HELP = (
    "In this order: new writes a folder, whose assignment.toml and sheet.md are yours to edit; "
    "calibrate finds from which score on there are points; check grades all that is known to be "
    "right or wrong, before you rely on it; pack writes what students get, and an autograder for "
    "Gradescope."
)
app = command_group("Start with: robsim assignment new park hw1")
app.command(cls=Command, help=new.HELP, epilog=new.EXAMPLE)(new.new)
app.command(cls=Command, help=calibrate.HELP, epilog=calibrate.EXAMPLE)(calibrate.calibrate)
app.command(cls=Command, help=check.HELP, epilog=check.EXAMPLE)(check.check)
app.command(cls=Command, help=pack.HELP, epilog=pack.EXAMPLE)(pack.pack)
