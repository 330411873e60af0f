#include "python/values.hpp"
#include "robsim/model/motion.hpp"
#include "robsim/simulation/robot/controllers.hpp"
#include "robsim/simulation/world/simulated_world.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

void bind_unicycle(py::module_& module) {
  Class<Unicycle> unicycle(public_in(module, "robsim"), "Unicycle", R"(
The robot on wheels that do not slip sideways: a ready `evaluate_model` in native code.

The robot has the constants of the `RobotModel`. It drives straight and turns like this model, but
in a curve it always drives along its heading. The object can be called like a callback:
``pose = unicycle(world)``.

Notes
-----
s(k) = -a2X s(k-1) + b1X u1(k-1) + b2X u2(k-1) + d1X is the distance driven in a step, and
x(k) = x(k-1) + s(k) cos heading(k-1), y(k) = y(k-1) + s(k) sin heading(k-1).

Examples
--------
>>> drive = {"control": robsim.DriveAround(), "seed": 1}
>>> model = robsim.Simulation(**drive).run(100)
>>> unicycle = robsim.Simulation(evaluate_model=robsim.Unicycle(), **drive).run(100)
>>> np.abs(unicycle.pose_true - model.pose_true).max(axis=0).round(1)
array([89.4, 32.2,  0. ])
)");
  unicycle.def(
      "__call__",
      [](const Unicycle& self, const WorldState& world) {
        return self(world.model, world.pose_1, world.pose_2, world.last_u);
      },
      "world"_a, "Return the pose of a step: array (3,).");
  const Fields fields([] { return Unicycle(); });
  define_value(unicycle, fields);
  define_repr(unicycle, fields);
}

Replay replay_from(const ArrayLike& u) {
  const Doubles rows = doubles_from(u, "u", Shape{-1, 2}, "one input a step, shape (N, 2), in V");
  std::vector<Input> inputs;
  for (py::ssize_t k = 0; k < rows.shape(0); ++k) inputs.push_back({rows.at(k, 0), rows.at(k, 1)});
  return Replay(std::move(inputs));
}

// A read-only view that keeps the controller alive.
py::array_t<double> inputs_of(const py::object& self) {
  static_assert(sizeof(Input) == 2 * sizeof(double));
  const std::vector<Input>& u = self.cast<const Replay&>().u();
  const double* first = u.empty() ? nullptr : &u.front().u1;
  return read_only(
      py::array_t<double>({static_cast<py::ssize_t>(u.size()), py::ssize_t{2}}, first, self));
}

py::bytes bytes_of(const Replay& replay) {
  const std::vector<Input>& u = replay.u();
  return {reinterpret_cast<const char*>(u.data()), u.size() * sizeof(Input)};
}

Replay replay_from_bytes(const py::bytes& bytes) {
  const auto numbers = py::module_::import("numpy").attr("frombuffer")(bytes);
  return replay_from(numbers.attr("reshape")(-1, 2));
}

void bind_replay(py::module_& module) {
  Class<Replay, Controller, std::shared_ptr<Replay>> replay(public_in(module, "robsim"), "Replay",
                                                            R"(
Repeats recorded inputs: step k gets the input of row k.

Parameters
----------
u : array (N, 2)
    The voltages of the left and the right motor (V), one row a step, such as ``trace.u``.

Raises
------
IndexError
    If it is called for a step without a row.

Examples
--------
>>> sim = robsim.Simulation(control=robsim.Replay([(0.2, 0.2), (0.2, -0.2)]), seed=1)
>>> sim.run(2).u
array([[ 0.2,  0.2],
       [ 0.2, -0.2]])
)");
  replay.def(py::init(&replay_from), "u"_a)
      .def_property_readonly("u", &inputs_of, "array (N, 2): the voltages (V), read-only.");
  define_repr(replay, "<Replay: inputs of {0.u.shape[0]} steps>");
  const Fields fields(&replay_from_bytes, Field("u", &bytes_of));
  define_record(replay, fields);
}

void bind_ready_controllers(py::module_& module) {
  Class<Controller, std::shared_ptr<Controller>>(public_in(module, "robsim.control"), "Controller",
                                                 R"(
A predefined controller in native code, which can be called like a callback: ``u = spin(step)``.

Examples
--------
>>> robsim.Spin()(robsim.Step(k=0))
array([ 0.05, -0.05])
)")
      .def(
          "__call__", [](const Controller& self, const Step& step) { return self(step); }, "step"_a,
          "Return the input of a step: array (2,), V.");

  Class<Spin, Controller, std::shared_ptr<Spin>> spin(public_in(module, "robsim"), "Spin", R"(
Turns on the spot: (+voltage, -voltage).

Parameters
----------
voltage : float
    Voltage of the left motor (V); at 0.05 V the default robot turns by 1.05 degrees a step.

Examples
--------
>>> trace = robsim.Simulation(control=robsim.Spin(), seed=1).run(50)
>>> abs(trace.pose_true[-1] - trace.pose_true[0]).round(2)  # px, px, rad
array([0.  , 0.  , 0.81])
)");
  const auto spin_fields = members<Spin>(
      [](const Spin& made) { made.check(); },
      Field("voltage", &Spin::voltage, "float: voltage of the left motor (V).", Spin().voltage));
  define_value(spin, spin_fields);
  define_repr(spin, spin_fields);

  const DriveAround defaults;
  Class<DriveAround, Controller, std::shared_ptr<DriveAround>> drive(public_in(module, "robsim"),
                                                                     "DriveAround", R"(
Drives around: each motor gets a random voltage, which is held for some steps.

Parameters
----------
low, high : float
    The voltages are uniform in [low, high) (V).
hold : int
    Steps for which a voltage is held.

Examples
--------
>>> trace = robsim.Simulation(control=robsim.DriveAround(), seed=1).run(100)
>>> len(np.unique(trace.u, axis=0))  # each input lasts some steps
10
)");
  const auto fields = members<DriveAround>(
      [](const DriveAround& made) { made.check(); }, by_name,
      Field("low", &DriveAround::low, "float: lowest voltage (V).", defaults.low),
      Field("high", &DriveAround::high, "float: highest voltage (V).", defaults.high),
      Field("hold", &DriveAround::hold, "int: number of steps for which a voltage is held.",
            defaults.hold));
  define_value(drive, fields);
  define_repr(drive, fields);
}

}  // namespace

void bind_controllers(py::module_& module) {
  bind_unicycle(module);
  bind_ready_controllers(module);
  bind_replay(module);
}
