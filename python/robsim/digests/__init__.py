"""Whether this machine gives the numbers that others do: ``python -m robsim.digests``."""

from robsim._base.public import present as _present
from robsim.digests._compare import Digest, DigestReport, compare_digests

__all__ = [
    "Digest",
    "DigestReport",
    "compare_digests",
]

_present(globals())
