"""No name of before the rooms is left anywhere: code, messages, documentation, notebooks.

As a program it prints where one stands: ``python tests/package/test_old_names.py``.
"""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

OLD = {
    # classes and functions
    r"Locator": "MarkerLayout",
    r"locator(?!\()": "markers",  # Playwright has one that is called
    r"Checkup|checkup": "CheckReport",
    r"raise_if_ill": "raise_for_problems",
    r"StudentsLine": "SourceLine",
    r"check_excitation": "identifiability",
    r"use_robot|chosen_robot|(?<!_)reset_robot": "set_default_robot, default_robot, ...",
    r"plane_map_from_points": "PlaneMap.from_points",
    r"read_picture|write_(picture|video)": "load_image, save_image, save_video",
    r"color_text": "colors_to_toml",
    r"regression_samples|samples_of": "regression, regression_of",
    r"\b(error|nees|nis|whiteness)_report\(": "estimation_errors, nees_consistency, ...",
    r"to_frame": "to_pandas",
    r"robsim\.VisualNoise": "GaussianNoise, UniformNoise",
    r"why_not_seen|explain_no_detection": "Detection.explanation, explain_missed",
    # attributes and arguments
    r"sim(ulation)?\.newest": "last_step",
    r"sim(ulation)?\.frame_of": "render_step",
    r"unit_errors?": "standard_errors_unscaled",
    r"is_of_the_model": "is_model_exact",
    r"claimed(_median)?": "reported_sd",
    r"world\.(last|before|u)": "world.pose_1, world.pose_2, world.last_u",
    r"trace\.(measured|held|estimated|valid|false)": "trace.pose_measured, ..., seen, is_false",
    r"(?<=\.)rms_(xy|heading_deg)": "rmse_xy, rmse_heading_deg",
    r"noise_percent|dropout_steps": "noise=GaussianNoise(40), dropout=Dropout(0.2, steps=5)",
    r"rotation=|(?<![._])phases=(?!phases)": "headings=",
    r"\bcamera=": "resolution=",
    r"\b(batch_estimate|regression_of)\([^)]*\bsamples=": "select=",
    r"RecursiveLeastSquares\([^)]*\bfilters=": "n_filters=",
    r"too (confident|cautious)": "optimistic, conservative",
    r"max_(voltage|speed)|min_voltage": "maximum_voltage, maximum_speed, minimum_voltage",
    r"(red|blue)_(area|polygon)": "areas, polygons of a MarkerLayout, by role",
    r"(?<=detection\.)(red|blue)|(?<=markers\.)(red|blue)|(?<=robot\.)(red|blue)": "... by role",
    # the command line
    r"robots add [^`]*--(red|blue)\b": "--marker red=POINTS",
    r"--(noise-percent|dropout-steps|rotation|places)\b": "--noise gaussian:10, --headings",
    # private words
    # "most=" is that of points, too.
    r"\b(least|above)=": "minimum=, exclusive_minimum=",
    r"stretch(es)?(?!;)": "segment",  # that of CSS stays
    r"[Pp]atient": "EstimatorUnderTest",
}
OTHERS = {old for old in OLD if old.startswith(("--", r"\b", "("))}  # with ends of their own
PATTERNS = {
    re.compile(old if old in OTHERS else rf"(?<!\w)(?:{old})(?!\w)"): new
    for old, new in OLD.items()
}
# Any of them, in a quarter of the time.
ANY = (
    re.compile(rf"(?<!\w)(?:{'|'.join(old for old in OLD if old not in OTHERS)})(?!\w)"),
    re.compile("|".join(old for old in OLD if old in OTHERS)),
)


def documents():
    """What users and maintainers read."""
    folders = ("python", "cpp", "notebooks", "tests", "assets")
    kinds = (
        ".py",
        ".pyi",
        ".cpp",
        ".hpp",
        ".md",
        ".ipynb",
        ".toml",
        ".txt",
        ".js",
        ".css",
        ".json",
    )
    files = [file for folder in folders for file in (ROOT / folder).rglob("*")]
    files += [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", ROOT / "run"]
    return [f for f in files if (f.suffix in kinds or f == ROOT / "run") and f != Path(__file__)]


def old_names():
    for file in documents():
        text = file.read_text(encoding="utf-8")
        if not any(pattern.search(text) for pattern in ANY):
            continue
        for pattern, new in PATTERNS.items():
            for match in pattern.finditer(text):
                line = text.count("\n", 0, match.start()) + 1
                yield f"{file.relative_to(ROOT)}:{line}: {match.group()!r} is now {new}"


@pytest.mark.long
@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_no_old_name_is_left():
    assert list(old_names()) == []


def test_an_old_name_would_be_found():
    texts = {"Locator": "from robsim import Locator", "camera": "Simulation(camera=(480, 480))"}
    for text in texts.values():
        for patterns in (PATTERNS, ANY):
            assert any(pattern.search(text) for pattern in patterns)


if __name__ == "__main__":
    found = list(old_names())
    print("\n".join(found) or "no old name is left")
    sys.exit(bool(found))
