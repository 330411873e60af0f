"""Tasks as environments of gymnasium, for learned controllers; needs ``pip install 'robsim[gym]'``.

Importing it registers ``"robsim/Park-v0"`` and ``"robsim/Follow-v0"``, for ``gymnasium.make``.
"""

from robsim.base.report.optional import import_optional as _import_optional

_import_optional("gymnasium", "robsim.teach.gym needs")

from robsim.teach.gym.environment import TaskEnv  # noqa: E402
from robsim.teach.gym.registration import register as _register  # noqa: E402

__all__ = ["TaskEnv"]

_register()
