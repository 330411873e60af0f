#include <algorithm>

#include "python/values.hpp"
#include "robsim/model/motion.hpp"
#include "robsim/model/robot_model.hpp"

using namespace robsim;
using namespace robsim::bindings;

namespace {

RobotModel model_from(const AxisMatrix& theta, double dt) { return RobotModel(theta, dt); }

// The arguments of the model for one step or for N of them: one row stands for all.
struct Steps {
  Doubles pose_1, pose_2, u;
  py::ssize_t count = 1;
  bool is_many = false;

  Steps(py::handle pose_1_value, py::handle pose_2_value, py::handle u_value) {
    const std::string pose = "a pose (x, y, heading) in px, px and rad";
    pose_1 = rows_from(pose_1_value, "pose_1", 3, pose);
    pose_2 = rows_from(pose_2_value, "pose_2", 3, pose);
    u = rows_from(u_value, "u", 2, "(u1, u2), the two voltages in V");
  }

  py::array_t<double> results(Shape shape) const {
    if (is_many) shape.insert(shape.begin(), count);
    return py::array_t<double>(shape);
  }

  static const double* row(const Doubles& rows, py::ssize_t i) {
    return rows.ndim() == 2 ? rows.data(i) : rows.data();
  }
  Input input(py::ssize_t i) const { return {row(u, i)[0], row(u, i)[1]}; }

 private:
  Doubles rows_from(py::handle value, const std::string& name, py::ssize_t width,
                    const std::string& one) {
    const Doubles rows = doubles_from(value, name, std::nullopt, one);
    const bool has_many = rows.ndim() == 2;
    if ((rows.ndim() != 1 && !has_many) || rows.shape(rows.ndim() - 1) != width) {
      throw py::value_error(name + " must be " + one + " or an array (N, " + std::to_string(width) +
                            "), got " + describe(value));
    }
    if (has_many && is_many && rows.shape(0) != count) {
      throw py::value_error(name + " must have as many rows as the arguments before, " +
                            std::to_string(count) + ", or be one, got " + describe(value));
    }
    if (has_many) count = rows.shape(0);
    is_many = is_many || has_many;
    return rows;
  }
};

UnwrappedPose unwrapped(const double* row) { return {row[0], row[1], row[2]}; }
Pose wrapped(const double* row) { return {row[0], row[1], wrap_angle(row[2])}; }

py::array_t<double> predict_many(const RobotModel& model, const Steps& steps, bool unwrap) {
  py::array_t<double> result = steps.results({3});
  for (py::ssize_t i = 0; i < steps.count; ++i) {
    Eigen::Map<UnwrappedPose> pose(result.mutable_data() + 3 * i);
    const double *pose_1 = steps.row(steps.pose_1, i), *pose_2 = steps.row(steps.pose_2, i);
    if (unwrap) {
      pose = model.predict(unwrapped(pose_1), unwrapped(pose_2), steps.input(i));
    } else {
      const Pose next = model.predict(wrapped(pose_1), wrapped(pose_2), steps.input(i));
      pose << next.x, next.y, next.heading;
    }
  }
  return result;
}

bool is_one(py::handle value) {
  return PyTuple_CheckExact(value.ptr()) ||
         (py::isinstance<Doubles>(value) && py::reinterpret_borrow<Doubles>(value).ndim() == 1);
}

py::array_t<double> predict_of(const RobotModel& model, const ArrayLike& pose_1,
                               const ArrayLike& pose_2, const ArrayLike& u, bool unwrapped) {
  // A callback predicts one pose a step.
  if (!unwrapped && is_one(pose_1) && is_one(pose_2) && is_one(u)) {
    return to_array(model.predict(pose_from(pose_1, "pose_1"), pose_from(pose_2, "pose_2"),
                                  input_from(u, "u")));
  }
  return predict_many(model, Steps(pose_1, pose_2, u), unwrapped);
}

py::array_t<double> jacobian_of(const RobotModel& model, const ArrayLike& pose_1,
                                const ArrayLike& pose_2, const ArrayLike& u) {
  const Steps steps(pose_1, pose_2, u);
  py::array_t<double> result = steps.results({3, 6});
  for (py::ssize_t i = 0; i < steps.count; ++i) {
    Eigen::Map<PoseJacobian>(result.mutable_data() + 18 * i) =
        model.jacobian(unwrapped(steps.row(steps.pose_1, i)), steps.input(i));
  }
  return result;
}

// Arguments from the fits: any finite or infinite numbers, since an iteration may diverge.
struct PathArguments {
  AxisMatrix theta;
  Doubles poses, u;

  PathArguments(py::handle theta_value, py::handle poses_value, const char* name, py::ssize_t rows,
                py::handle u_value)
      : poses(numbers_from(poses_value, name, Shape{rows, 3}, "poses, shape (n, 3)")),
        u(numbers_from(u_value, "u", Shape{-1, 2}, "one input a step, shape (n, 2)")) {
    const Doubles numbers =
        numbers_from(theta_value, "theta", Shape{3, 5}, "the 15 parameters, shape (3, 5)");
    theta = Eigen::Map<const AxisMatrix>(numbers.data());
    if (u.shape(0) < 2 || (rows < 0 && u.shape(0) != poses.shape(0))) {
      throw py::value_error("u must have a row for each step, two or more, got " + describe(u));
    }
  }

  Eigen::Map<const Inputs> inputs() const { return {u.data(), u.shape(0), 2}; }
};

py::array_t<double> simulated_path_of(const ArrayLike& theta, const ArrayLike& first,
                                      const ArrayLike& u) {
  const PathArguments given(theta, first, "first", 2, u);
  const Path path = simulated_path(
      given.theta,
      Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(given.poses.data()),
      given.inputs());
  return py::array_t<double>({path.rows(), path.cols()}, path.data());
}

py::array_t<double> path_sensitivities_of(const ArrayLike& theta, const ArrayLike& path,
                                          const ArrayLike& u) {
  const PathArguments given(theta, path, "path", -1, u);
  auto* kept = new std::vector<PathDerivatives>(path_sensitivities(
      given.theta, Eigen::Map<const Path>(given.poses.data(), given.poses.shape(0), 3),
      given.inputs()));
  return py::array_t<double>({py::ssize_t(kept->size()), py::ssize_t{3}, py::ssize_t{21}},
                             kept->front().data(), owner_of(kept));
}

// The samples of an unbroken record of N poses: N - 2 regressors and outputs.
using Arrays = py::typing::Tuple<py::array_t<double>, py::array_t<double>>;

Arrays regression_of(const ArrayLike& poses_value, const ArrayLike& u_value) {
  const Doubles poses = doubles_from(poses_value, "poses", Shape{-1, 3}, "poses, shape (N, 3)");
  const py::ssize_t n = poses.shape(0);
  const Doubles u = doubles_from(u_value, "u", Shape{n, 2}, "one input a pose, shape (N, 2)");
  const py::ssize_t count = std::max<py::ssize_t>(n - 2, 0);
  py::array_t<double> phi({count, py::ssize_t{3}, py::ssize_t{5}});
  py::array_t<double> y({count, py::ssize_t{3}});
  const auto pose = [&](py::ssize_t k) {
    return Pose{poses.at(k, 0), poses.at(k, 1), wrap_angle(poses.at(k, 2))};
  };
  for (py::ssize_t k = 2; k < n; ++k) {
    const Input input{u.at(k - 1, 0), u.at(k - 1, 1)};
    const Regression sample = regression(pose(k), pose(k - 1), pose(k - 2), input);
    std::copy_n(sample.phi.data(), 15, phi.mutable_data(k - 2));
    std::copy_n(sample.y.data(), 3, y.mutable_data(k - 2));
  }
  return Arrays(py::make_tuple(phi, y));
}

void bind_parameters(py::module_& module) {
  Class<RobotParameters> parameters(public_in(module, "robsim"), "RobotParameters", R"(
The physical parameters of the robot; the defaults come from the original program.

Parameters
----------
mass : float
    Mass m (kg).
inertia : float
    Moment of inertia I (kg m^2).
linear_friction, angular_friction : float
    Viscous friction Fv (N s/m) and Fw (N m s/rad).
wheel_radius, wheel_base : float
    Wheel radius r and distance of the wheels L (m).
motor_gain : tuple of two floats
    Torque per voltage alpha of the left and the right motor (N m/V).
motor_offset : tuple of two floats
    Torque at 0 V beta of the left and the right motor (N m).
dt : float
    Sample time T (s).

Raises
------
ValueError
    If a value is not physical; the message names the value and the reason.

Examples
--------
>>> light, heavy = (robsim.RobotParameters(mass=mass) for mass in (0.3, 0.6))
>>> [float(robsim.RobotModel(p).theta[0, 2].round(3)) for p in (light, heavy)]
[0.208, 0.108]
)");
  const auto field = [](const char* name, auto get, const char* doc) {
    return Field(name, get, doc, std::invoke(get, RobotParameters()));
  };
  const auto fields = members(
      &check_parameters, by_name,  //
      field("mass", &RobotParameters::mass, "float: mass (kg)."),
      field("inertia", &RobotParameters::inertia, "float: moment of inertia (kg m^2)."),
      field("linear_friction", &RobotParameters::linear_friction,
            "float: viscous friction of the position (N s/m)."),
      field("angular_friction", &RobotParameters::angular_friction,
            "float: viscous friction of the heading (N m s/rad)."),
      field("wheel_radius", &RobotParameters::wheel_radius, "float: wheel radius (m)."),
      field("wheel_base", &RobotParameters::wheel_base, "float: distance of the wheels (m)."),
      field("motor_gain", &RobotParameters::motor_gain,
            "tuple of float: torque per voltage, left and right (N m/V)."),
      field("motor_offset", &RobotParameters::motor_offset,
            "tuple of float: torque at 0 V, left and right (N m)."),
      field("dt", &RobotParameters::dt, "float: sample time (s)."));
  define_value(parameters, fields);
  define_repr(parameters, fields);
}

}  // namespace

void bind_model(py::module_& module) {
  bind_parameters(module);

  Class<RobotModel> model(public_in(module, "robsim"), "RobotModel", R"(
One-step predictor of a differential-drive robot, linear in its 15 parameters.

Per axis: x(k) = a1 x(k-1) + a2 x(k-2) + (b1 u1(k-1) + b2 u2(k-1) + d1) cos heading(k-1), with sin
for y and 1 for the heading. The equations allow the robot to slide sideways.

Parameters
----------
parameters : RobotParameters, optional
    The physical robot.

Raises
------
ValueError
    If the predictor would be unstable: a1 must lie between 0 and 2.

Notes
-----
Source: Pereira et al., Data-Based Dynamical Modelling of Externally Observed Actuators-Only
Robots, IEEE Trans. SMC A 30(4), 2000.

Examples
--------
>>> robsim.RobotModel().theta.round(3)  # rows X, Y, heading: -a1, -a2, b1, b2, d1
array([[ 1.938, -0.938,  0.208,  0.208,  0.   ],
       [ 1.938, -0.938,  0.208,  0.208,  0.   ],
       [ 1.833, -0.833,  0.031, -0.031,  0.   ]])
)");
  model.def(py::init<const RobotParameters&>(), "parameters"_a = RobotParameters())
      .def_static("from_theta", &model_from, "theta"_a, py::kw_only(),
                  "dt"_a = RobotParameters().dt, R"(
Return the model with these predictor parameters.

Parameters
----------
theta : array (3, 5)
    Rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
dt : float
    Sample time (s).
)")
      .def("predict", &predict_of, "pose_1"_a, "pose_2"_a, "u"_a, py::kw_only(),
           "unwrapped"_a.noconvert() = false, R"(
Return the pose of step k, or the poses of N steps.

Parameters
----------
pose_1, pose_2 : array (3,) or (N, 3)
    Poses of steps k-1 and k-2: x, y (work-area px), heading (rad).
u : array (2,) or (N, 2)
    Input of step k-1 (V).
unwrapped : bool
    Use the headings unchanged, without a jump by a full turn, and do not wrap the result's heading.

Returns
-------
array (3,) or (N, 3)
    The pose, with a heading in (-pi, pi]. An argument with a single row applies to all N steps.

Raises
------
TypeError, ValueError
    If an argument has the wrong type or shape, or is not finite.
)")
      .def("jacobian", &jacobian_of, "pose_1"_a, "pose_2"_a, "u"_a, R"(
Return the derivatives of the pose of step k by the two previous poses.

Parameters
----------
pose_1, pose_2 : array (3,) or (N, 3)
    Poses of steps k-1 and k-2: x, y (work-area px), heading (rad).
u : array (2,) or (N, 2)
    Input of step k-1 (V).

Returns
-------
array (3, 6) or (N, 3, 6)
    Columns 0..2: the derivatives by x, y and heading of `pose_1`; 3..5: of `pose_2`.

Raises
------
TypeError, ValueError
    If an argument has the wrong type or shape, or is not finite.
)")
      .def("steps_in", &RobotModel::steps_in, "dt"_a, R"(
Return the number of the model's steps in a time: several if frames were lost.

Parameters
----------
dt : float
    The time between two poses (s), such as ``step.dt``.

Raises
------
ValueError
    If the time is not a positive multiple of the model's dt, with a tolerance of a quarter of that
    dt.
)");
  define_repr(model, "<RobotModel: dt = {0.dt!r} s, theta =\n{0.theta}>");
  define_record(model,
                Fields(&model_from,
                       Field("theta", &RobotModel::theta,
                             "array (3, 5): rows X, Y, P (heading), columns a1, a2, b1, b2, d1."),
                       Field("dt", &RobotModel::dt, "float: sample time (s).")));

  public_in(module, "robsim.estimation")
      .def("check_mean_interval", &check_mean_interval, "time"_a, "n_steps"_a, "dt"_a,
           "Raise ValueError if so many steps in a time (s), 10 or more, are not dt long on "
           "average.")
      .def("model_steps", py::vectorize(&model_steps), "time"_a, "dt"_a, R"(
Return the number of steps of a model with this dt (s) in each time (s); see RobotModel.steps_in.
)")
      .def("simulated_path", &simulated_path_of, "theta"_a, "first"_a, "u"_a,
           R"(
Return the path of the robot model with any parameters, stable or not.

Parameters
----------
theta : array (3, 5)
    Rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
first : array (2, 3)
    The first two poses.
u : array (n, 2)
    Inputs (V), n >= 2.

Returns
-------
array (n, 3)
    The poses; headings are not wrapped.
)")
      .def("path_sensitivities", &path_sensitivities_of, "theta"_a, "path"_a, "u"_a, R"(
Return the derivatives of a simulated path.

Parameters
----------
theta : array (3, 5)
    The parameters.
path : array (n, 3)
    The path simulated with these parameters.
u : array (n, 2)
    Inputs (V).

Returns
-------
array (n, 3, 21)
    Derivatives by the first two values of x, of y and of the heading, and by the 15 parameters.
)")
      .def("regression", &regression_of, "poses"_a, "u"_a, R"(
Return the samples of the robot model's predictor in an unbroken record.

Parameters
----------
poses : array (N, 3)
    Poses of N steps in a row: x, y (work-area px), heading (rad), wrapped or not.
u : array (N, 2)
    The inputs given at these steps (V).

Returns
-------
phi : array (N - 2, 3, 5)
    Regressors of steps 2..N-1 for the axes X, Y and P (heading).
y : array (N - 2, 3)
    Outputs; y = sum(phi * theta, axis=2) for the true theta.

Examples
--------
>>> trace = robsim.Simulation(control=robsim.DriveAround(), seed=1).run(50)
>>> phi, y = robsim.estimation.regression(trace.pose_true, trace.u)
>>> np.allclose((phi * robsim.RobotModel().theta).sum(axis=2), y)
True
)");
}
