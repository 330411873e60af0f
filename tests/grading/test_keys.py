"""The secret key: what follows from it comes again, and tells nothing."""

import itertools
import os
import sys
import unicodedata

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robsim.teach import AssignmentError, Key

KEY = Key(bytes(range(32)))
NAMES = st.text(max_size=8)

# There it says of each file that nobody has looked who can read it.
pytestmark = pytest.mark.filterwarnings("ignore:the readers of the key:UserWarning")


def test_what_follows_from_a_key_never_changes():
    """Marks can be explained years later only if these numbers stay."""
    assert KEY.world_seed("s001", "ekf", 4) == 137540712394165050075844414622724383675
    assert KEY.robot_seed("s001", "ekf", 4) == 270315796137081953195451554642676242302
    assert KEY.frame_noise("s001", "ekf", 4, 7) == 3155017358506260713
    assert KEY.pseudonym("s001") == "xuaweaybfz"


def test_each_thing_has_its_own_seed():
    names = list(itertools.product(["", "s1", "s2", "s1\0"], ["", "t", "s1"], [0, 1, 256]))
    seeds = [seed(*name) for name in names for seed in (KEY.world_seed, KEY.robot_seed)]
    seeds += [Key.public().world_seed(*name) for name in names]
    assert len({*seeds}) == len(seeds)
    assert all(0 <= seed < 2**128 for seed in seeds)
    assert max(seeds) > 2**120


@settings(max_examples=50)
@given(NAMES, NAMES, NAMES, NAMES, st.integers(0, 3), st.integers(0, 3))
def test_no_two_names_are_one(student, test, other_student, other_test, run, other_run):
    one, other = (student, test, run), (other_student, other_test, other_run)
    plain = [
        tuple(unicodedata.normalize("NFC", str(part)) for part in name) for name in (one, other)
    ]
    assert (KEY.world_seed(*one) == KEY.world_seed(*other)) == (plain[0] == plain[1])


def test_a_name_is_the_same_on_each_file_system():
    assert KEY.world_seed("Müller", "t", 0) == KEY.world_seed("Mu\u0308ller", "t", 0)
    assert KEY.world_seed("\udcff", "t", 0) != KEY.world_seed("?", "t", 0)


def test_noise_keys():
    keys = KEY.noise_keys("s001", "ekf", 4, 1000)
    assert keys.dtype == np.uint64
    assert len({*keys.tolist()}) == 1000
    assert keys[:10].tolist() == KEY.noise_keys("s001", "ekf", 4, 10).tolist()
    assert [KEY.frame_noise("s001", "ekf", 4, i) for i in (0, 999)] == keys[[0, 999]].tolist()
    assert not {*keys.tolist()} & {*KEY.noise_keys("s001", "ekf", 5, 1000).tolist()}
    bits = np.unpackbits(keys.view(np.uint8)).mean()
    assert abs(bits - 0.5) < 5 * 0.5 / np.sqrt(64_000)
    names = {KEY.pseudonym(f"s{i}") for i in range(1000)}
    assert len(names) == 1000
    assert all(len(name) == 10 and name.isascii() and name.isalnum() for name in names)


def test_a_key_says_nothing_of_itself():
    key = Key.new()
    assert key != Key.new()
    assert repr(key) == "<Key: secret>"
    assert Key.public() == Key.public()
    assert not key.is_public


def test_what_cannot_be_a_key():
    assert Key(bytes(16)) != KEY
    with pytest.raises(ValueError, match=r"secret .*got 15"):
        Key(bytes(15))
    with pytest.raises(ValueError, match="run"):
        KEY.world_seed("s", "t", -1)


@pytest.mark.skipif(sys.platform == "win32", reason="modes of files are not Windows'")
def test_a_key_is_kept_from_others(tmp_path):
    key = Key.new()
    old = os.umask(0)
    try:
        key.save(tmp_path / "key")
    finally:
        os.umask(old)
    assert (tmp_path / "key").stat().st_mode & 0o777 == 0o600
    assert Key.load(tmp_path / "key") == key
    with pytest.raises(FileExistsError):
        key.save(tmp_path / "key")
    for mode in (0o640, 0o604, 0o610):
        (tmp_path / "key").chmod(mode)
        with pytest.raises(
            AssignmentError, match=r"other users can read the key .*: run chmod 600 "
        ):
            Key.load(tmp_path / "key")


def test_who_can_read_a_key_is_not_known_on_windows(tmp_path, monkeypatch):
    Key.new().save(tmp_path / "key")
    monkeypatch.setattr("robsim.teach.grading.keys.sys.platform", "win32")
    with pytest.warns(UserWarning, match="not checked on Windows"):
        Key.load(tmp_path / "key")


def test_what_is_no_key_is_refused(tmp_path):
    words = ["", "abc", "00" * 15]
    for content in ("", "hello", "\xff", *(f"robsim-key-1 {word}" for word in words), "0" * 77):
        (tmp_path / "key").write_text(content)
        (tmp_path / "key").chmod(0o600)
        with pytest.raises(AssignmentError, match="is not a key"):
            Key.load(tmp_path / "key")
    with pytest.raises(AssignmentError, match="cannot be read"):
        Key.load(tmp_path / "other")
