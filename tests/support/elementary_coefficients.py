"""Compute cpp/robsim/base/elementary/coefficients.hpp: ``python FILE > coefficients.hpp``.

All of them come from integers and decimal fractions of 60 digits, none from a library's functions.
A polynomial is the one that meets its function at the nodes of Chebyshev, whose largest error is
within a factor of 3 of the least possible (Trefethen, Approximation Theory and Approximation
Practice, 2013, ch. 15 and 16).
"""

from collections.abc import Callable
from decimal import Decimal, getcontext
from fractions import Fraction

getcontext().prec = 60

Function = Callable[[Decimal], Decimal]


def series(first: Decimal, next_term: Callable[[Decimal, int], Decimal]) -> Decimal:
    """Sum terms, each from the last one and its index, until they no longer count."""
    total, term, n = Decimal(0), first, 0
    while abs(term) > Decimal(10) ** -70:
        total += term
        n += 1
        term = next_term(term, n)
    return total


def sine_part(z: Decimal) -> Decimal:
    """Return (sin(r)/r - 1)/r^2 for r^2 = z."""
    return series(Decimal(-1) / 6, lambda term, n: -term * z / ((2 * n + 2) * (2 * n + 3)))


def cosine_part(z: Decimal) -> Decimal:
    """Return (cos(r) - 1 + r^2/2)/r^4 for r^2 = z."""
    return series(Decimal(1) / 24, lambda term, n: -term * z / ((2 * n + 3) * (2 * n + 4)))


def arc_tangent_part(z: Decimal) -> Decimal:
    """Return (atan(r)/r - 1)/r^2 for r^2 = z."""
    return series(Decimal(-1) / 3, lambda term, n: -term * z * (2 * n + 1) / (2 * n + 3))


def exponential_part(r: Decimal) -> Decimal:
    """Return (exp(r) - 1 - r)/r^2."""
    return series(Decimal(1) / 2, lambda term, n: term * r / (n + 2))


def logarithm_part(z: Decimal) -> Decimal:
    """Return (log((1 + s)/(1 - s))/s - 2)/s^2 for s^2 = z."""
    return series(Decimal(2) / 3, lambda term, n: term * z * (2 * n + 1) / (2 * n + 3))


def arc_tangent(x: Fraction) -> Decimal:
    """Return atan(x) for |x| <= 1 by Euler's series."""
    t = Decimal(x.numerator) / Decimal(x.denominator)
    y = t * t / (1 + t * t)
    # atan t = t/(1 + t^2) sum over n of 2n/(2n + 1) y each after the one before
    return series(t / (1 + t * t), lambda term, n: term * y * (2 * n) / (2 * n + 1))


def pi_as_integer(bits: int) -> int:
    """Return pi times 2^bits by Machin's formula, pi = 16 atan(1/5) - 4 atan(1/239)."""

    def inverse_arc_tangent(n: int, one: int) -> int:
        total, power, k = 0, one // n, 1
        while power:
            total += power // k if k % 4 == 1 else -(power // k)
            power, k = power // n**2, k + 2
        return total

    guard = 32
    one = 1 << (bits + guard)
    return (16 * inverse_arc_tangent(5, one) - 4 * inverse_arc_tangent(239, one)) >> guard


def polynomial(function: Function, low: Decimal, high: Decimal, degree: int) -> list[float]:
    """Return the coefficients, the constant one first, of the polynomial at Chebyshev's nodes."""
    nodes = [
        (low + high) / 2 + (high - low) / 2 * cosine(PI * (2 * i + 1) / (2 * degree + 2))
        for i in range(degree + 1)
    ]
    differences = [function(node) for node in nodes]
    for order in range(1, degree + 1):
        for i in range(degree, order - 1, -1):
            rise = differences[i] - differences[i - 1]
            differences[i] = rise / (nodes[i] - nodes[i - order])
    # Newton's form, multiplied out from the innermost bracket
    result = [Decimal(0)]
    for node, difference in zip(reversed(nodes), reversed(differences), strict=True):
        shifted = [Decimal(0), *result]
        result = [a - node * b for a, b in zip(shifted, [*result, Decimal(0)], strict=True)]
        result[0] += difference
    return [float(c) for c in result[: degree + 1]]


def cosine(x: Decimal) -> Decimal:
    """Return cos(x) by its series."""
    return series(Decimal(1), lambda term, n: -term * x * x / ((2 * n - 1) * (2 * n)))


def parts(value: Decimal, bits: list[int]) -> list[float]:
    """Cut a number between 0.5 and 2 into parts of so many bits, and a last one of 53."""
    result = []
    position = 0
    for width in bits:
        position += width
        part = int(value * 2**position) / Decimal(2) ** position
        result.append(float(part))
        value -= part
    return [*result, float(value)]


def line(name: str, values: list[float]) -> str:
    """Return a constant, or an array of several, as C++."""
    numbers = [value.hex() for value in values]
    if len(numbers) == 1:
        return f"constexpr double {name} = {numbers[0]};"
    rows = "".join(f"    {number},\n" for number in numbers)
    return f"constexpr double {name}[] = {{\n{rows}}};"


PI = Decimal(pi_as_integer(240)) / 2**240
FIRST_BITS = 33
WORDS = 38  # of 32 bits: those that the largest double asks for
STEPS = 16


def coefficients() -> str:
    """Return the header."""
    two_over_pi = (1 << (32 * WORDS + 1 + 1300)) // pi_as_integer(1300)
    words = [0, 0] + [(two_over_pi >> (32 * (WORDS - 1 - i))) & 0xFFFFFFFF for i in range(WORDS)]
    angles = [arc_tangent(Fraction(k, STEPS)) for k in range(STEPS + 1)]
    quarter = (PI / 4) ** 2
    half_log = Decimal(2).ln() / 2
    largest = (Decimal(2).sqrt() - 1) / (Decimal(2).sqrt() + 1)
    blocks = [
        "// Made by tests/support/elementary_coefficients.py, which says how. Do not edit.",
        "// clang-format off\n#pragma once\n",
        "#include <cstdint>\n",
        "namespace robsim::elementary {\n",
        "// pi/2 in parts of 33 bits: their products with an integer of 20 bits are exact.",
        line("pi_2_parts", parts(PI / 2, [FIRST_BITS, FIRST_BITS, FIRST_BITS])),
        line("two_over_pi", [float(2 / PI)]),
        "\n// As the double next to it and the rest.",
        line("pi_2", parts_of_two(PI / 2)),
        line("pi_", parts_of_two(PI)),
        "\n// The binary digits of 2/pi, 32 in a word, from the 64th place before the point on.",
        "constexpr std::uint32_t two_over_pi_words[] = {\n"
        + "".join(f"    {word:#010x},\n" for word in words)
        + "};",
        "\n// (sin(r)/r - 1)/r^2 and (cos(r) - 1 + r^2/2)/r^4 in r^2, |r| <= pi/4.",
        line("sine_part", polynomial(sine_part, Decimal(0), quarter, 5)),
        line("cosine_part", polynomial(cosine_part, Decimal(0), quarter, 5)),
        "\n// atan(k/16), as the double next to it and the rest.",
        line("angle", [parts_of_two(angle)[0] for angle in angles]),
        line("angle_rest", [parts_of_two(angle)[1] for angle in angles]),
        "\n// (atan(r)/r - 1)/r^2 in r^2, |r| <= 1/32.",
        line("arc_tangent_part", polynomial(arc_tangent_part, Decimal(0), Decimal(1) / 1000, 4)),
        "\n// log 2: a part of 32 bits, whose products with exponents are exact, and the rest.",
        line("log_2_parts", parts(2 * half_log, [32])),
        line("one_over_log_2", [float(1 / (2 * half_log))]),
        "\n// (exp(r) - 1 - r)/r^2 in r, |r| <= log(2)/2.",
        line("exponential_part", polynomial(exponential_part, -half_log, half_log, 9)),
        "\n// (log((1 + s)/(1 - s))/s - 2)/s^2 in s^2, 1/sqrt(2) <= (1 + s)/(1 - s) <= sqrt(2).",
        line("logarithm_part", polynomial(logarithm_part, Decimal(0), largest**2, 6)),
        "\n}  // namespace robsim::elementary",
    ]
    return "\n".join(blocks) + "\n"


def parts_of_two(value: Decimal) -> list[float]:
    """Return the double next to a number, and the rest."""
    return [float(value), float(value - Decimal(float(value)))]


if __name__ == "__main__":
    print(coefficients(), end="")
