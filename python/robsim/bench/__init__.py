"""Benchmarks of robsim against OpenCV and numpy, which ``robsim bench`` runs."""

from robsim._base.public import present as _present
from robsim.bench._cases import BenchResult, Case
from robsim.bench._run import run_bench

__all__ = [
    "BenchResult",
    "Case",
    "run_bench",
]

_present(globals())
