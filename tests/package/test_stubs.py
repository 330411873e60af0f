import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import robsim

SCRIPT = Path(__file__).parents[1] / "support" / "write_stub.py"


@pytest.mark.long
def test_the_stub_of_the_core_is_up_to_date(tmp_path):
    if not shutil.which("pybind11-stubgen", path=str(Path(sys.executable).parent)):
        raise RuntimeError("the tests need pybind11-stubgen: pip install pybind11-stubgen")
    subprocess.run([sys.executable, SCRIPT, tmp_path], check=True, capture_output=True)
    shipped = Path(robsim.__file__).with_name("_core.pyi").read_text()
    assert (tmp_path / "robsim/_core.pyi").read_text() == shipped, "write it anew: ./run stubs"


def test_the_package_says_that_it_is_typed():
    assert Path(robsim.__file__).with_name("py.typed").is_file()
