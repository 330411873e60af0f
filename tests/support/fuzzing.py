"""What the fuzzers share: how long, what counts as robust, and inputs out of the ordinary."""

import os
from collections import Counter

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from robsim import _core

#: Few by default; `./run fuzz` asks for many, with other random numbers each round.
EXAMPLES = int(os.environ.get("ROBSIM_FUZZ_EXAMPLES", "10"))

fuzzed = settings(
    max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), database=None
)

#: What a wrong input may end in. Anything else, or a crash, is a fault.
REFUSALS = (TypeError, ValueError, OverflowError, MemoryError)
LONGEST_MESSAGE = 2000  # letters: a message never quotes a whole file

#: How often a call of a test was taken, and refused: what is always refused tests nothing.
taken: Counter[str] = Counter()
refused: Counter[str] = Counter()


def check_words(error):
    """A refusal speaks to the user, and not at length."""
    text = str(error)
    assert text, f"a bare {type(error).__name__}"
    assert len(text) <= LONGEST_MESSAGE, text[:300]
    assert not any(word in text for word in ("std::", "pybind11", "incompatible function")), text


def attempt(call, /, *arguments, also=(), **options):
    """Return the result of a call, or None if it refuses its arguments in words.

    `also`: exceptions beside the usual ones that may end it.
    """
    name = call.__name__
    try:
        result = call(*arguments, **options)
    except (*REFUSALS, *also) as error:
        refused[name] += 1
        check_words(error)
        return None
    taken[name] += 1
    return result


def on_every_path(call):
    """The results of a call on each path of the processor."""
    before = _core.cpu_path()
    try:
        for path in _core.cpu_paths():
            _core.force_cpu_path(path)
            yield call()
    finally:
        _core.force_cpu_path(before)


# Numbers: those at which rules change, and any others.
EDGES = (0.0, -0.0, 1.0, -1.0, 0.5, 255.0, 256.0, np.pi, -np.pi, 1e-300, 5e-324, 1e100, 1e308)
FLOATS = st.one_of(
    st.sampled_from((*EDGES, np.inf, -np.inf, np.nan)), st.floats(-1e4, 1e4), st.floats()
)
#: Those that most functions take: half of the inputs should get past the checks.
ORDINARY = st.floats(-2000, 2000)
POSITIVE = st.floats(1e-3, 1e3)
NUMBERS = st.one_of(ORDINARY, ORDINARY, FLOATS)
SEEDS = st.integers(0, 2**32 - 1)


def mostly(ordinary, odd):
    """Return a strategy that draws odd values in about one case of four."""
    # `one_of` takes each strategy once, however often it is given.
    return st.integers(0, 3).flatmap(lambda i: odd if i == 3 else ordinary)


@st.composite
def arrays(draw, *shapes, numbers=NUMBERS):
    """A float array of one of the shapes (callables draw a length): random, with a few edges."""
    shape = draw(st.sampled_from(shapes))
    shape = tuple(draw(n) if isinstance(n, st.SearchStrategy) else n for n in shape)
    rng = np.random.default_rng(draw(SEEDS))
    scale = draw(st.sampled_from((1.0, 100.0, 1e-6, 1e6)))
    values = rng.normal(scale=scale, size=shape)
    if values.size:
        for _ in range(draw(st.integers(0, 3))):
            values.flat[draw(st.integers(0, values.size - 1))] = draw(numbers)
    return laid_out(draw, values)


def laid_out(draw, values):
    """The same values in another memory layout, or of another type."""
    form = draw(st.sampled_from(("C", "C", "C", "F", "strided", "list", "float32", "read-only")))
    if form == "F":
        return np.asfortranarray(values)
    if form == "strided":
        wide = np.zeros((*values.shape[:-1], 2 * values.shape[-1])) if values.ndim else values
        if values.ndim:
            wide[..., ::2] = values
        return wide[..., ::2] if values.ndim else wide
    if form == "list":
        return values.tolist()
    if form == "float32":
        with np.errstate(over="ignore"):
            return values.astype(np.float32)
    if form == "read-only":
        values.setflags(write=False)
    return values


@st.composite
def images(draw, largest=70):
    """Images: of one pixel, of one row, noise, flat, robot-like discs; any row stride."""
    height, width = draw(st.integers(1, largest)), draw(st.integers(1, largest))
    rng = np.random.default_rng(draw(SEEDS))
    kind = draw(st.sampled_from(("noise", "flat", "discs", "blocks")))
    if kind == "noise":
        pixels = rng.integers(0, 256, (height, width, 3)).astype(np.uint8)
    elif kind == "blocks":
        small = rng.integers(0, 2, (height // 4 + 1, width // 4 + 1, 3)) * 255
        pixels = small.repeat(4, 0).repeat(4, 1)[:height, :width].astype(np.uint8)
    else:
        pixels = np.full((height, width, 3), rng.integers(0, 256, 3), np.uint8)
    if kind == "discs":
        y, x = np.indices((height, width))
        for color in ((200, 40, 40), (40, 60, 200), rng.integers(0, 256, 3)):
            center, radius = rng.uniform(-5, largest, 2), rng.uniform(0.5, 9)
            pixels[np.hypot(x - center[0], y - center[1]) < radius] = color
    return with_stride(draw, pixels)


def with_stride(draw, pixels):
    """The same pixels with rows apart, upside down, broadcast, or as they are."""
    form = draw(st.sampled_from(("C", "C", "padded rows", "every other row", "flipped", "one row")))
    if form == "padded rows":
        wide = np.zeros((pixels.shape[0], pixels.shape[1] + 5, 3), np.uint8)
        wide[:, : pixels.shape[1]] = pixels
        return wide[:, : pixels.shape[1]]
    if form == "every other row":
        return pixels[::2]
    if form == "flipped":
        return pixels[::-1]
    if form == "one row":
        return np.broadcast_to(pixels[:1], pixels.shape)
    return pixels


@st.composite
def mutations(draw, content: bytes):
    """A file's content with bytes changed, cut out, put in, repeated, or exchanged."""
    content = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        if not content:
            break
        at = draw(st.integers(0, len(content) - 1))
        n = draw(st.integers(1, 40))
        what = draw(st.sampled_from(("set", "set", "flip", "cut", "insert", "repeat", "end")))
        if what == "set":
            content[at] = draw(st.sampled_from((0, 1, 0x7F, 0x80, 0xFF, 10, 34, 61, 91)))
        elif what == "flip":
            content[at] ^= 1 << draw(st.integers(0, 7))
        elif what == "cut":
            del content[at : at + n]
        elif what == "insert":
            content[at:at] = draw(st.binary(min_size=1, max_size=n))
        elif what == "repeat":
            content[at:at] = content[at : at + n] * draw(st.sampled_from((1, 3, 200)))
        else:
            del content[at:]
    return bytes(content)
