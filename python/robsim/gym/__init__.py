"""Tasks as environments of gymnasium, for learned controllers; needs ``pip install 'robsim[gym]'``.

Importing it registers ``"robsim/Park-v0"`` and ``"robsim/Follow-v0"``, for ``gymnasium.make``.
"""

from robsim._base.public import present as _present
from robsim._base.report.optional import import_optional as _import_optional

_import_optional("gymnasium", "robsim.gym needs")

from robsim.gym._environment import TaskEnv  # noqa: E402
from robsim.gym._registration import register as _register  # noqa: E402

__all__ = ["TaskEnv"]

_register()
_present(globals())
