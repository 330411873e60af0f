#include <cmath>

#include "python/interpreter.hpp"
#include "python/values.hpp"
#include "robsim/base/system.hpp"
#include "robsim/lab/motors/motor_link.hpp"
#include "robsim/lab/motors/motor_receiver.hpp"
#include "robsim/lab/motors/protocol.hpp"
#include "robsim/lab/motors/safety.hpp"

using namespace robsim;
using namespace robsim::bindings;

template <>
constexpr Choices<MotorEvent::Kind> robsim::bindings::choices<MotorEvent::Kind> = {
    {"input", MotorEvent::Kind::input},     {"repeat", MotorEvent::Kind::repeat},
    {"stop", MotorEvent::Kind::stop},       {"failure", MotorEvent::Kind::failure},
    {"timeout", MotorEvent::Kind::timeout}, {"silence", MotorEvent::Kind::silence}};
template <>
constexpr Choices<Command::Kind> robsim::bindings::choices<Command::Kind> = {
    {"u", Command::Kind::input}, {"s", Command::Kind::stop}, {"a", Command::Kind::answer}};

namespace {

const py::call_guard<WithoutInterpreter> no_interpreter{};

template <typename Error>
void bind_error(py::module_& module, const char* name, py::handle base, const char* doc) {
  const auto error = py::register_local_exception<Error>(module, name, base);
  error.attr("__module__") = "robsim.lab";
  error.attr("__doc__") = doc;
}

void bind_event(py::module_& module) {
  Class<MotorEvent> event(public_in(module, "robsim.lab"), "MotorEvent", R"(
A message on a line to a robot, or an action of the robot itself.

Examples
--------
>>> with robsim.lab.MotorReceiver() as robot:
...     with robsim.lab.UdpMotors("127.0.0.1", robot.port) as motors:
...         sent_at = motors((0.5, -0.25))
>>> [(event.kind, event.u.tolist()) for event in motors.events if event.kind != "repeat"][:2]
[('input', [0.5, -0.25]), ('stop', [0.0, 0.0])]
)");
  const auto fields = members<MotorEvent>(
      nullptr, by_name, Field("t", &MotorEvent::t, "float: when (s, clock of time.monotonic)."),
      Field("u", &MotorEvent::u, "array (2,): the input (V), 0 for a stop."),
      Field("kind", &MotorEvent::kind,
            "str: \"input\", a new input; \"repeat\", the same again; \"stop\"; \"failure\", a "
            "line that could not be written; \"timeout\", the robot stopped without a line; "
            "\"silence\", a robot that answered before has not for a second."));
  define_record(event, fields);
  define_repr(event, fields);
}

void bind_counts(py::module_& module) {
  Class<LineCounts> counts(public_in(module, "robsim.lab"), "LineCounts", R"(
Numbers of lines that a robot has received.

Examples
--------
>>> import socket, time
>>> with robsim.lab.MotorReceiver() as robot, socket.socket(type=socket.SOCK_DGRAM) as sender:
...     size = sender.sendto(b"0.5 V" + bytes([10]), ("127.0.0.1", robot.port))
...     while not robot.counts.damaged:
...         time.sleep(0.01)
...     print(robot.counts)
LineCounts(valid=0, damaged=1, old=0, foreign=0)
)");
  const auto fields = members<LineCounts>(
      nullptr, by_name, Field("valid", &LineCounts::valid, "int: obeyed lines."),
      Field("damaged", &LineCounts::damaged,
            "int: lines that were damaged, too long, or outside the protocol."),
      Field("old", &LineCounts::old, "int: lines that arrived after a newer one."),
      Field("foreign", &LineCounts::foreign, "int: lines of another sender than the current one."));
  define_record(counts, fields);
  define_repr(counts, fields);
}

Limits make_limits(std::optional<double> voltage, std::optional<double> slew_rate) {
  Limits limits;
  limits.voltage = voltage.value_or(limits.voltage);
  limits.slew_rate = slew_rate.value_or(limits.slew_rate);
  limits.check();
  return limits;
}

std::optional<double> given(double limit) {
  return std::isinf(limit) ? std::nullopt : std::optional(limit);
}

void bind_limits(py::module_& module) {
  Class<Limits> limits(public_in(module, "robsim.lab"), "Limits", R"(
Limits of the inputs of a robot's motors.

Both inputs are scaled by the same factor, so that the robot drives the same curve more slowly.
Separate limits would change the curve. The change from one input to the next is scaled in the same
way. Stopping is never slowed down: an input of 0, 0 passes immediately.

Parameters
----------
voltage : float, optional
    Largest size of the input of a motor (V). Default: no limit.
slew_rate : float, optional
    Largest change of the input of a motor in a second (V/s). Default: no limit.

Raises
------
ValueError
    If a limit is not above 0.

Examples
--------
>>> limits = robsim.lab.Limits(voltage=1.0)
>>> limits.applied((2.0, 1.0), (0.0, 0.0), 0.2)
array([1. , 0.5])
)");
  const Fields fields(
      &make_limits, by_name,
      Field(
          "voltage", [](const Limits& self) { return given(self.voltage); },
          "float or None: largest size of the input of a motor (V).", std::nullopt),
      Field(
          "slew_rate", [](const Limits& self) { return given(self.slew_rate); },
          "float or None: largest change of the input of a motor in a second (V/s).",
          std::nullopt));
  define_value(limits, fields);
  define_repr(limits, fields);
  limits.def(
      "applied",
      [](const Limits& self, const Input& u, const Input& before, double dt) {
        if (!(dt >= 0)) throw py::value_error("dt must be at least 0 s");
        return self.applied(u, before, dt);
      },
      "u"_a, "before"_a, "dt"_a, R"(
Return the input within the limits.

Parameters
----------
u : array (2,)
    The wanted input (V).
before : array (2,)
    The present input of the motors (V).
dt : float
    Duration of the present input (s).

Returns
-------
array (2,)
    The input (V).
)");
}

void bind_line(py::module_& module) {
  Class<Line, std::shared_ptr<Line>>(public_in(module, "robsim._core"), "Line",
                                     "One end of a line to a robot.")
      .def_static("udp_to", &Line::udp_to, "host"_a, "port"_a, no_interpreter)
      .def_static("of_descriptor", &Line::of_descriptor, "descriptor"_a, "name"_a);
}

void bind_link(py::module_& module) {
  Class<MotorLink, std::shared_ptr<MotorLink>> link(
      public_in(module, "robsim._core"), "MotorLink",
      "The sender's end of a line to a robot. Users take robsim.lab.UdpMotors or SerialMotors.");
  link.def(py::init([](Line& line, double ttl, double hold) {
             return make_native<MotorLink>(std::move(line), ttl, hold);
           }),
           "line"_a, py::kw_only(), "ttl"_a, "hold"_a)
      .def("__call__", &MotorLink::send, "u"_a, no_interpreter, R"(
Send an input, and return its time.

The interpreter continues meanwhile. The link repeats the input until the next one.

Parameters
----------
u : array (2,)
    Voltages of the left and the right motor (V), sent to 0.1 mV.

Returns
-------
float
    Time of writing it to the line (s, clock of time.monotonic).

Raises
------
robsim.lab.LineError
    If the line cannot be written within 50 ms, or failed since the last input; the link then sends
    stops to the robot for 2 s.
robsim.lab.HaltedError
    If the robot was halted, for example because a frame was late.
ValueError
    If an input is beyond 1000 V.
)")
      .def("stop", &MotorLink::stop, no_interpreter, R"(
Stop the robot: send a stop at once, and repeat it for 2 s, five times in the first 0.1 s.

Returns
-------
float
    Time of the first stop (s, clock of time.monotonic).

Raises
------
robsim.lab.LineError
    If the line cannot be written; the link tries again.
)")
      .def("_check_stop", &MotorLink::check_stop,
           "Raise LineError, once, if the last stop was not sent.")
      .def(
          "halt", [](MotorLink& self) { self.halt(); }, no_interpreter,
          "Stop the robot, and refuse inputs until `resume` is called; raises nothing.")
      .def("resume", &MotorLink::resume, no_interpreter, "Accept inputs again after `halt`.")
      .def("close", &MotorLink::close, no_interpreter, R"(
Stop the robot and close the line; a second call does nothing.

Raises
------
robsim.lab.LineError
    If the line failed since the last input: the robot may not have received the stop.
)")
      .def_property_readonly("name", &MotorLink::name, "str: name of the line in errors.")
      .def_property_readonly("ttl", &MotorLink::time_to_live,
                             "float: the robot stops if it receives nothing for so long (s).")
      .def_property_readonly("hold", &MotorLink::hold,
                             "float: the link stops the robot if no input is sent for so long (s).")
      .def_property_readonly("is_halted", &MotorLink::is_halted,
                             "bool: True if the link refuses inputs.")
      .def_property_readonly("is_closed", &MotorLink::is_closed, "bool: True after `close`.")
      .def_property_readonly("events", &MotorLink::events,
                             "list of MotorEvent: the sent lines; the newest 100 000.")
      .def_property_readonly("is_silent", &MotorLink::is_silent,
                             "bool: whether lines are sent, and a robot that answered before has "
                             "not answered for a second.")
      .def_property_readonly(
          "round_trip_times",
          [](const MotorLink& self) {
            const std::vector<double> times = self.round_trip_times();
            return to_array(times.data(), {static_cast<py::ssize_t>(times.size())});
          },
          "array (N,): from a line to its answer (s), the newest 1000; empty if the robot does not "
          "answer.");
}

void bind_protocol(py::module_& module) {
  public_in(module, "robsim._core")
      .def(
          "to_line",
          [](Command::Kind kind, std::uint16_t number, const Input& u, int time_to_live) {
            return py::bytes(to_line({kind, number, u, time_to_live}));
          },
          "kind"_a, "number"_a, "u"_a, "time_to_live"_a,
          "Return a line of the protocol to a robot.")
      .def(
          "parse_line",
          [](const py::bytes& line) -> py::object {
            const auto command = parse_line(std::string_view(line));
            if (!command) return py::none();
            return py::make_tuple(command->kind, command->number, command->u.u1, command->u.u2,
                                  command->time_to_live);
          },
          "line"_a, "Return the parts of a line, without its line break; None if damaged.");
}

std::shared_ptr<MotorReceiver> make_receiver(int port, const std::string& host,
                                             std::optional<int> descriptor, double actuation_delay,
                                             bool answers) {
  if (port < 0 || port > 65535) {
    throw py::value_error("port must lie within 0..65535, got " + std::to_string(port));
  }
  if (descriptor && *descriptor < 0) {
    throw py::value_error("descriptor must be at least 0, got " + std::to_string(*descriptor));
  }
  const WithoutInterpreter others;
  Line line = descriptor
                  ? Line::of_descriptor(*descriptor, "descriptor " + std::to_string(*descriptor))
                  : Line::udp_at(host, port);
  return make_native<MotorReceiver>(std::move(line), actuation_delay, answers);
}

double checked_seconds(const char* name, double time) {
  if (std::isfinite(time)) return time;
  throw py::value_error(std::string(name) + " must be finite (s), got " + to_text(time));
}

void bind_receiver(py::module_& module) {
  Class<ReceivedInput, std::shared_ptr<ReceivedInput>>(
      public_in(module, "robsim._core"), "ReceivedInput", "The inputs received by a robot.")
      .def(
          "mean",
          [](const ReceivedInput& self, double start, double end) {
            return self.mean(checked_seconds("start", start), checked_seconds("end", end));
          },
          "start"_a, "end"_a, R"(
Return the mean input of the robot's motors between two times.

Parameters
----------
start, end : float
    The times (s, clock of time.monotonic).

Returns
-------
array (2,)
    The input (V); 0 while the robot stood. For equal times, the input at this time.

Raises
------
ValueError
    If a time is not finite.
)");

  Class<MotorReceiver, ReceivedInput, std::shared_ptr<MotorReceiver>>(
      public_in(module, "robsim.lab"), "MotorReceiver", R"(
The robot's end of a motor line: a separate thread reads inputs by the protocol of PROTOCOL.md.

The receiver replaces a robot in rehearsals and tests. It stops the motors if it receives no valid
line within the time to live set by the sender.

Parameters
----------
port : int
    UDP port to listen on; 0 = any free port, see `port`.
host : str
    Address to listen on.
descriptor : int, optional
    A file descriptor to read instead of UDP, such as an end of a pseudo-terminal. It is copied, and
    made non-blocking.
actuation_delay : float
    Delay from receiving an input to acting on it (s).
answers : bool
    Whether to answer each valid line, so that the sender knows the round trip time.

Raises
------
robsim.lab.LineError
    If the port is in use, or the address does not exist.

Examples
--------
>>> with robsim.lab.MotorReceiver() as robot:
...     print(robot.input, robot.counts)
[0. 0.] LineCounts(valid=0, damaged=0, old=0, foreign=0)
)")
      .def(py::init(&make_receiver), "port"_a = 0, py::kw_only(), "host"_a = "127.0.0.1",
           "descriptor"_a = py::none(), "actuation_delay"_a = 0.0, "answers"_a.noconvert() = true)
      .def("close", &MotorReceiver::close, no_interpreter,
           "Stop listening; the robot stops at the end of the time to live.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def(
          "__exit__",
          [](MotorReceiver& self, const py::object&, const py::object&, const py::object&) {
            self.close();
          },
          "kind"_a, "error"_a, "traceback"_a, no_interpreter)
      .def_property_readonly("name", &MotorReceiver::name, "str: name of the line.")
      .def_property_readonly("port", &MotorReceiver::port,
                             "int: the port to listen on; 0 for a descriptor.")
      .def_property_readonly("actuation_delay", &MotorReceiver::actuation_delay,
                             "float: delay from receiving an input to acting on it (s).")
      .def_property_readonly("is_closed", &MotorReceiver::is_closed, "bool: True after `close`.")
      .def_property_readonly("input", &MotorReceiver::input,
                             "array (2,): the present input of the motors (V).")
      .def_property_readonly(
          "events", &MotorReceiver::events,
          "list of MotorEvent: received lines and its own stops; the newest 100 000.")
      .def_property_readonly("counts", &MotorReceiver::counts,
                             "LineCounts: numbers of received lines.")
      .def("__repr__", [](const MotorReceiver& self) {
        return "<MotorReceiver at " + self.name() + (self.is_closed() ? ", closed>" : ">");
      });
}

}  // namespace

void bind_motors(py::module_& module) {
  bind_error<LineError>(module, "LineError", PyExc_OSError,
                        "A line to a robot cannot be opened, read or written.");
  bind_error<HaltedError>(module, "HaltedError", PyExc_RuntimeError,
                          "An input was refused, since the robot was halted.");
  bind_event(module);
  bind_counts(module);
  bind_limits(module);
  bind_line(module);
  bind_link(module);
  bind_protocol(module);
  bind_receiver(module);
}
