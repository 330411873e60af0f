"""The core's own sines and their like: how near they are, and that nothing else is in use."""

import ast
import ctypes
import math
import platform
import shutil
import subprocess
import sys
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import elementary_coefficients as reference
from robsim import _core

ROOT = Path(__file__).parents[2]
HEADER = ROOT / "cpp/robsim/base/elementary/coefficients.hpp"

# Of the C library's mathematics the core may have what IEEE 754 fixes to the last bit.
EXACT = {
    *("ceil", "floor", "trunc", "round", "lround", "llround", "rint", "nearbyint", "fmod"),
    *("remainder", "sqrt", "sqrtf", "fmax", "fmin", "ceilf", "floorf", "roundf"),
}


def error_in_units(value, right):
    """The error of a double in units of the last place, for a Decimal that is right."""
    return abs(Decimal(value) - right) / Decimal(math.ulp(float(right)))


def right_sine(x, quarter_turns=0):
    """sin(x + quarter_turns pi/2), from as many digits of pi as x asks for."""
    with localcontext() as context:
        context.prec = 400
        half_pi = Decimal(reference.pi_as_integer(1300)) / 2**1301
        n = (Decimal(x) / half_pi).to_integral_value()
        rest = Decimal(x) - n * half_pi
        context.prec = 60
        quadrant = (int(n) + quarter_turns) % 4
        if quadrant % 2:
            value = reference.cosine(+rest)
        else:
            value = reference.series(
                +rest, lambda term, n: -term * rest * rest / (2 * n * (2 * n + 1))
            )
        return -value if quadrant > 1 else value


few = settings(max_examples=30)


@few
@given(st.floats(allow_nan=False, allow_infinity=False))
@example(sys.float_info.max)
@example(math.pi)
@example(1e6)
@example(float.fromhex("0x1.6ac5b262ca1ffp+849"))
def test_sines_of_angles_of_any_size(x):
    for function, turns in ((_core.sin, 0), (_core.cos, 1)):
        right = right_sine(x, turns)
        if right == 0:
            assert math.copysign(1, function(x)) == math.copysign(1, x)
        else:
            assert error_in_units(function(x), right) < 1


@few
@given(st.floats(-745, 709))
def test_powers_of_e(x):
    with localcontext() as context:
        context.prec = 60
        assert error_in_units(_core.exp(x), Decimal(x).exp()) < 1


@few
@given(st.floats(min_value=0, exclude_min=True, allow_infinity=False))
@example(1.0)
@example(math.nextafter(1, 2))
def test_logarithms(x):
    with localcontext() as context:
        context.prec = 60
        right = Decimal(x).ln()
        assert error_in_units(_core.log(x), right) < 1 if right else _core.log(x) == 0


@few
@given(*2 * [st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)])
def test_lengths_and_angles_of_points(x, y):
    length, angle = _core.hypot(x, y), _core.atan2(y, x)
    with localcontext() as context:
        context.prec = 60
        right = (Decimal(x) ** 2 + Decimal(y) ** 2).sqrt()
        assert not right or error_in_units(length, right) < 1
    # atan2 is held against long double in C++
    assert angle == pytest.approx(math.atan2(y, x), rel=3e-16)


def test_arrays_give_what_their_numbers_give():
    x = np.linspace(-5, 5, 30).reshape(2, 3, 5)
    for name in ("sin", "cos", "exp"):
        function = getattr(_core, name)
        result = function(x)
        assert result.shape == x.shape
        assert result.ravel().tolist() == [function(number) for number in x.ravel().tolist()]
        assert function(0) == function(0.0)


@pytest.mark.skipif(not HEADER.is_file(), reason="needs the sources")
def test_the_coefficients_are_those_that_the_script_computes():
    assert HEADER.read_text() == reference.coefficients()


def undefined_symbols():
    if shutil.which("nm") is None or platform.libc_ver()[0] != "glibc":
        pytest.skip("needs nm, of the binutils, and glibc")
    command = ["nm", "-D", "--undefined-only", _core.__file__]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    return {line.split()[-1].split("@")[0] for line in lines}


def test_the_core_takes_no_sine_from_the_c_library():
    symbols = undefined_symbols()
    assert "memcpy" in symbols
    mathematics, c_library = ctypes.CDLL("libm.so.6"), ctypes.CDLL("libc.so.6")
    assert hasattr(mathematics, "sincos")
    assert not hasattr(c_library, "sincos")
    # what both have, frexp and ldexp among them, is exact
    taken = {s for s in symbols if hasattr(mathematics, s) and not hasattr(c_library, s)}
    assert taken <= EXACT
    assert not [s for s in symbols if s.startswith("_ZGV")]  # sines of several numbers at a time


@pytest.mark.slow
def test_the_core_has_neither_fused_nor_extended_arithmetic():
    if shutil.which("objdump") is None or platform.machine() != "x86_64":
        pytest.skip("needs objdump, of the binutils, and an x86-64 processor")
    command = ["objdump", "-d", "--no-show-raw-insn", _core.__file__]
    code = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    used = {line.split("\t")[1].split()[0] for line in code.splitlines() if line.count("\t") == 1}
    assert "mulsd" in used
    assert not [
        name for name in used if name.startswith(("vfmadd", "vfmsub", "vfnmadd", "vfnmsub"))
    ]
    assert not used & {"fadd", "faddp", "fmul", "fmulp", "fsub", "fsubp", "fdiv", "fdivp", "fsin"}


# --- what is computed in Python on the way from the seed to the world, the frames and the inputs

ON_THE_PATH = [
    *("base/seeds.py", "control/excitation.py", "control/path_following.py"),
    *("vision/robots/definition.py", "vision/imaging/images.py", "vision/imaging/noise.py"),
    "simulation",
]

# Exact, or rounded as IEEE 754 has it; all else of math and numpy may differ in the last digit.
EXACT_IN_PYTHON = {
    *("sqrt", "fsum", "floor", "ceil", "copysign", "radians", "pi", "inf", "nan"),
    *("isfinite", "isnan", "isinf", "isclose"),
}
INEXACT_IN_NUMPY = {
    *("sin", "cos", "tan", "arctan2", "arctan", "arcsin", "arccos", "exp", "log", "log2", "log10"),
    *("expm1", "log1p", "hypot", "power", "cbrt", "dot", "vdot", "inner", "matmul", "einsum"),
    *("fft", "linalg", "interp", "convolve", "correlate", "tensordot", "sinc", "angle"),
    "float_power",
}
# These only decide, with a margin: whether to refuse or to warn, which samples may be the largest.
HARMLESS = {
    "control/excitation.py": {"exp", "fft"},
    "simulation/world/disturbances.py": {"linalg"},
    "simulation/mirrored_frames.py": {"cos", "sin", "@"},
    "simulation/options.py": {"degrees"},
}


def inexact_operations(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.MatMult):
            yield "@"
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if (node.value.id == "math" and node.attr not in EXACT_IN_PYTHON) or (
                node.value.id == "np" and node.attr in INEXACT_IN_NUMPY
            ):
                yield node.attr
        elif isinstance(node, ast.ImportFrom) and node.module == "math":
            yield from (alias.name for alias in node.names)


def path_files():
    package = Path(sys.modules["robsim"].__file__).parent
    for name in ON_THE_PATH:
        place = package / name
        files = [place] if place.is_file() else sorted(place.rglob("*.py"))
        assert files, name
        yield from ((str(file.relative_to(package)), file) for file in files)


def test_no_path_depends_on_a_function_that_differs_between_machines():
    for source in ("np.sin(1)", "math.hypot(1, 2)", "a @ b", "np.linalg.solve(a, b)"):
        assert list(inexact_operations(ast.parse(source)))
    found = {}
    for name, file in path_files():
        if "templates" in name:
            continue  # the user's
        operations = set(inexact_operations(ast.parse(file.read_text())))
        if operations - HARMLESS.get(name, set()):
            found[name] = operations
    assert not found
