"""Speed against what else there is."""

from robsim.bench.cases import BenchResult, Case
from robsim.bench.run import run_bench

__all__ = ["BenchResult", "Case", "run_bench"]
