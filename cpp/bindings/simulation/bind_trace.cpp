#include <pybind11/stl.h>

#include "python/public_names.hpp"
#include "robsim/simulation/trace.hpp"

namespace py = pybind11;
using namespace robsim;
using robsim::bindings::public_in;

namespace {

using Units = py::typing::Dict<py::str, py::str>;

Units units_of(const TraceGroup& group) {
  Units units;
  for (const TraceField& field : group.fields) units[field.name.c_str()] = field.unit;
  return units;
}

py::typing::Tuple<int, py::ellipsis> shape_of(const TraceGroup& group) {
  return py::tuple(py::cast(group.shape));
}

}  // namespace

void bind_trace(py::module_& module) {
  bindings::Class<TraceGroup>(public_in(module, "robsim.trace"), "TraceGroup", R"(
Columns of a trace that are recorded together.
)")
      .def_readonly("name", &TraceGroup::name, "str: name of the group.")
      .def_property_readonly("shape", &shape_of, "tuple of int: shape of the numbers of a step.")
      .def_property_readonly("units", &units_of,
                             "dict of str to str: unit of each column, in the order of a row.")
      .def_readonly("description", &TraceGroup::description, "str: what it is, in one line.")
      .def_readonly("is_flag", &TraceGroup::is_flag, "bool: a number above 0 stands for true.")
      .def_readonly("missing", &TraceGroup::missing, "float: stands where it was not recorded.")
      .def_readonly("in_simulated", &TraceGroup::in_simulated,
                    "bool: the trace of a simulated run must have it.")
      .def_readonly("in_recorded", &TraceGroup::in_recorded,
                    "bool: the trace of frames from elsewhere must have it.");

  public_in(module, "robsim._core").def("trace_schema", &trace_schema, R"(
Return the groups of columns of a trace, without `state` and `blobs_<color>`, whose widths vary.

Returns
-------
list of TraceGroup
    The groups in the order of the documentation.
)");
}
