// Python callables as stages: their calls, their errors, their results.
#pragma once

#include <unordered_map>

#include "python/numpy.hpp"
#include "robsim/simulation/loop.hpp"
#include "robsim/simulation/remote/remote_robot.hpp"
#include "robsim/simulation/remote/remote_world.hpp"
#include "robsim/simulation/robot/controllers.hpp"

namespace robsim::bindings {

/// A user's callable in a slot. What goes wrong in it reaches the user with the slot, the step
/// and where the callable is defined. It does not keep the callable alive: SlotValues do.
class Callback {
 public:
  /// `what` is the name in messages, if it is no callback. Throws py::type_error unless the value
  /// is callable.
  Callback(std::string slot, py::handle function, std::string what = "");

  /// Calls it at step k (-1 = at the start). Its exception passes on with a note.
  template <typename... Objects>
  py::object operator()(std::int64_t k, const Objects&... objects) const {
    PyObject* const arguments[] = {objects.ptr()..., nullptr};
    PyObject* const result =
        PyObject_Vectorcall(function_.ptr(), arguments, sizeof...(objects), nullptr);
    if (result) return py::reinterpret_steal<py::object>(result);
    fail(k);
  }

  /// Converts a result; an error in that names the callable, too.
  template <typename Convert>
  auto convert(std::int64_t k, const Convert& conversion) const {
    try {
      return conversion();
    } catch (const py::builtin_exception& error) {
      error.set_error();
      refuse(k);
    } catch (const std::invalid_argument& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
      refuse(k);
    } catch (py::error_already_set& error) {
      error.restore();
      fail(k);
    }
  }

  /// Throws the Python exception that is set, raised by the callable itself, with a note and a
  /// record of where it came from.
  [[noreturn]] void fail(std::int64_t k) const;

  /// Throws the Python exception that is set, raised on the callable's result, as a CallbackError.
  [[noreturn]] void refuse(std::int64_t k) const;

 private:
  std::string slot_;
  std::string what_;
  py::handle function_;
};

/// The newest step as Python sees it: one object for all callbacks and, unless one of them keeps
/// it, for all steps.
class StepObject {
 public:
  const py::object& of(const StepPointer& step) {
    if (step.get() != step_) {
      object_ = py::cast(step);
      step_ = step.get();
    }
    return object_;
  }

  void forget() {
    object_ = py::object();
    step_ = nullptr;
  }

  /// True if it is the step's object, without another holder.
  bool is_only_holder(const StepPointer& step) const {
    return step.get() == step_ && step.use_count() == 2 && object_.ref_count() == 1;
  }

 private:
  py::object object_;
  const Step* step_ = nullptr;
};

/// A user's own estimator object: what init_parameter_estimator returned.
class ObjectEstimator : public ParameterEstimator {
 public:
  explicit ObjectEstimator(py::object object) : object_(std::move(object)) {}

  AxisMatrix update(Step& step) override;
  void check() const override;
  bool is_interpreted() const override { return true; }
  const py::object& object() const { return object_; }

 private:
  py::object object_;
};

/// The estimator as Python sees it.
py::object to_python(const std::shared_ptr<ParameterEstimator>& estimator);

/// The Python values in slots. They are here, and not in the slots, so that Python's garbage
/// collector can see them: a callback often refers to its own simulation.
struct SlotValues {
  std::unordered_map<std::string, py::object> values;

  /// Other objects that only it holds.
  py::handle also_held() const { return {}; }
  void let_go() {}
};

/// Lets Python's garbage collector look into the slots of a class.
template <typename Slotted>
void collect_garbage(PyHeapTypeObject* heap_type) {
  PyTypeObject& type = heap_type->ht_type;
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (!py::detail::is_holder_constructed(self)) return 0;
    for (const auto& slot : py::cast<Slotted&>(py::handle(self)).values) {
      Py_VISIT(slot.second.ptr());
    }
    Py_VISIT(py::cast<const Slotted&>(py::handle(self)).also_held().ptr());
    return 0;
  };
  type.tp_clear = [](PyObject* self) {
    if (py::detail::is_holder_constructed(self)) {
      py::cast<Slotted&>(py::handle(self)).values.clear();
      py::cast<Slotted&>(py::handle(self)).let_go();
    }
    return 0;
  };
}

/// Refuses robsim's own stage of a slot in this process from now on: a submission could reach it.
void close_default(const std::string& slot);

/// The loop with Python values in the slots of its robot half.
class SlottedLoop : public Loop, public SlotValues {
 public:
  SlottedLoop(std::shared_ptr<World> world, const RobotOptions& robot, IdentifyFrom identify_from);

  /// Puts a value into the slot of a name: a callable, a native component, True for the default
  /// of an optional stage, None for its default.
  void set_slot(const std::string& slot, const py::object& value);

  /// Throws the error of a stage as the Python exception of the callable in its slot.
  [[noreturn]] void refuse(const ResultError& error) const;

  /// The user's estimator, which often refers to its simulation; null while another object holds
  /// it.
  py::handle also_held() const;
  void let_go();

  StepObject step_object;  // empty between two runs
};

// The halves of a loop in two processes, with the callables that exchange their messages.

/// They do not keep the callables alive: the values do, where the garbage collector sees them.
class PythonRemoteRobot : public RemoteRobot, public SlotValues {
 public:
  PythonRemoteRobot(Options options, const py::object& exchange, const py::object& refuse)
      : RemoteRobot(
            std::move(options),
            [exchange = py::handle(exchange)](const std::string& message, const ImageView* pixels,
                                              const char* slot, std::int64_t k) {
              const auto following = pixels ? std::optional(copy_of(*pixels)) : std::nullopt;
              return exchange(py::bytes(message), following, slot, k).cast<std::string>();
            },
            [refuse = py::handle(refuse)](const char* slot, std::int64_t k,
                                          const std::string& what) { refuse(slot, k, what); }) {
    values = {{"exchange", exchange}, {"refuse", refuse}};
  }
};

class PythonRemoteWorld : public RemoteWorld, public SlotValues {
 public:
  PythonRemoteWorld(Options options, const py::object& exchange)
      : RemoteWorld(std::move(options),
                    [exchange = py::handle(exchange)](const std::string& message) {
                      return exchange(py::bytes(message)).cast<std::optional<std::string>>();
                    }) {
    values = {{"exchange", exchange}};
  }
};

}  // namespace robsim::bindings
