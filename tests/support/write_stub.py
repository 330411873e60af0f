"""Write the type stub of the core: `python write_stub.py FOLDER`.

The core is loaded without the package around it, since that gives its classes their public names.
"""

import importlib.util
import sys
from types import ModuleType

import pybind11_stubgen

package = ModuleType("robsim")
package.__path__ = list(importlib.util.find_spec("robsim").submodule_search_locations)
sys.modules["robsim"] = package

sys.argv = ["pybind11-stubgen", "robsim._core", "--exit-code", "-o", sys.argv[1]]
pybind11_stubgen.main()
