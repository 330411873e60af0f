"""robsim in places that are no good for it: beside files that hide modules, in no folder."""

import os
import subprocess
import sys

import pytest


def ended(folder, *arguments, before=None):
    run = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        preexec_fn=before,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    return run.returncode, run.stderr.splitlines()


@pytest.mark.parametrize("name", ["numpy", "random", "copy", "tomllib"])
@pytest.mark.parametrize("words", ["-c|import robsim; robsim.Simulation", "-m|robsim|run"])
def test_a_file_that_hides_a_module_is_named(tmp_path, name, words):
    (tmp_path / f"{name}.py").write_text("x = 1\n")
    _, said = ended(tmp_path, *words.split("|"))
    assert f"{name}.py hides the module {name}, which robsim needs: rename" in said[-1]


@pytest.mark.skipif(os.name == "nt", reason="a folder in use stays there")
def test_a_folder_that_is_gone_is_told(tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    status, said = ended(folder, "-m", "robsim", "run", before=folder.rmdir)
    assert (status, said) == (2, ["error: the current folder no longer exists"])


@pytest.mark.skipif(os.name == "nt", reason="closes a descriptor as a shell of Unix does")
def test_a_command_runs_without_stderr(tmp_path):
    command = ("-m", "robsim", "run", "--steps", "3", "--out", "here")
    status, _ = ended(tmp_path, *command, before=lambda: os.close(2))
    assert status == 0
    assert (tmp_path / "here").is_dir()
