"""Write the type stub of the core: `python write_stub.py FOLDER`.

The names of the core say where users find them, such as robsim.vision.Blob. In the stub of the core
they are its own: the core is loaded without the package around it, and says so.
"""

import importlib
import importlib.util
import inspect
import re
import sys
from pathlib import Path
from types import ModuleType

import pybind11_stubgen

package = ModuleType("robsim")
package.__path__ = list(importlib.util.find_spec("robsim").submodule_search_locations)
sys.modules["robsim"] = package
core = importlib.import_module("robsim._core")
for name, value in vars(core).items():
    home = getattr(value, "__module__", "")
    if home.startswith("robsim"):
        setattr(sys.modules.setdefault(home, ModuleType(home)), name, value)
        value.__module__ = core.__name__


def no_arguments(function: object) -> None:
    """Send the generator to the first line of the doc: only there are the types."""
    raise TypeError(function)


inspect.getfullargspec = no_arguments

folder = Path(sys.argv[1])
sys.argv = ["pybind11-stubgen", core.__name__, "--exit-code", "-o", str(folder)]
pybind11_stubgen.main()

stub = folder / "robsim" / "_core.pyi"
text = re.sub(r"^import robsim[.\w]*\n", "", stub.read_text(), flags=re.MULTILINE)
names = "|".join(name for name in vars(core) if not name.startswith("_"))
text = re.sub(rf"(?<=[\[ (|])robsim(?:\.[a-z]+)?\.({names})(?=[\], )|:\n])", r"\1", text)
text = re.sub(  # of what changes, and so has no hash
    r"^( +)__hash__: typing.ClassVar\[None\] = None$",
    r"\1__hash__: typing.ClassVar[None]  # type: ignore[assignment]",
    text,
    flags=re.MULTILINE,
)
stub.write_text(re.sub(r"\(self: \w+", "(self", text))
