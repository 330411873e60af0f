"""The names that a misspelled one is taken for."""

import pytest

from robsim._base.spelling import check_names, closest, suggestion

OPTIONS = ("measure", "noise", "motor_delay", "control")


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("mesure", "measure"),
        ("NOIZE", "noise"),
        ("motordelay", "motor_delay"),
        ("Motor-Delay", "motor_delay"),
        ("zzz", None),
        ("", None),
    ],
)
def test_the_closest_name(name, meant):
    assert closest(name, OPTIONS) == meant


def test_the_end_of_a_message():
    assert suggestion("mesure", OPTIONS) == "; did you mean 'measure'?"
    assert suggestion("zzz", OPTIONS) == ""
    assert suggestion("mesure", ()) == ""


def test_a_name_keeps_its_own_spelling():
    assert closest("gausiannoise", ["GaussianNoise"]) == "GaussianNoise"


def test_names_are_checked():
    check_names("there is no key", ["noise"], OPTIONS, TypeError)
    with pytest.raises(TypeError, match=r"^there is no key 'noize': did you mean 'noise'\?$"):
        check_names("there is no key", ["noise", "noize"], OPTIONS, TypeError)
    with pytest.raises(ValueError, match="'zzz': there are measure, noise, motor_delay, control"):
        check_names("there is no key", ["zzz"], iter(OPTIONS), ValueError)
