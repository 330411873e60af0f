#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include "python/public_names.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"

namespace py = pybind11;
using namespace robsim::simd;
using robsim::bindings::public_in;

void bind_simd(py::module_& module) {
  public_in(module, "robsim._core")
      .def(
          "cpu_path", [] { return std::string(name_of(cpu_path())); },
          "Return which instructions the hot loops use: \"baseline\", \"avx2\" or \"avx512\".");
  public_in(module, "robsim._core")
      .def(
          "cpu_paths",
          [] {
            std::vector<std::string> names;
            for (const CpuPath path : cpu_paths()) names.emplace_back(name_of(path));
            return names;
          },
          "Return the paths available on this processor, the fastest last.");
  public_in(module, "robsim._core")
      .def(
          "force_cpu_path",
          [](const std::string& name) {
            for (const CpuPath path : cpu_paths()) {
              if (name == name_of(path)) {
                force_cpu_path(path);
                return;
              }
            }
            throw std::invalid_argument("path must be one that this processor has, got '" + name +
                                        "'");
          },
          py::arg("path"), R"(
Use other instructions from now on. The results are identical, bit for bit.

Parameters
----------
path : str
    One of `cpu_paths`.

Raises
------
ValueError
    If it is not available on this processor.
)");
}
