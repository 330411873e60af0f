#include <functional>
#include <numeric>

#include "python/callbacks.hpp"
#include "python/interpreter.hpp"
#include "python/signature.hpp"
#include "robsim/simulation/remote/message_socket.hpp"
#include "robsim/simulation/world/simulated_world.hpp"

using namespace robsim;
using namespace robsim::bindings;

template <>
constexpr Choices<StageBit> robsim::bindings::choices<StageBit> = {
    {"estimate_parameters", parameters_bit},
    {"measure", measure_bit},
    {"estimate_state", estimate_bit},
    {"control", control_bit}};

namespace {

std::uint32_t bits_of(const std::vector<StageBit>& slots) {
  return std::accumulate(slots.begin(), slots.end(), std::uint32_t{0}, std::bit_or<>());
}

std::shared_ptr<PythonRemoteRobot> make_robot(const py::object& exchange, const py::object& refuse,
                                              const std::vector<StageBit>& slots,
                                              const std::shared_ptr<World>& any_world,
                                              bool sends_frames, bool sends_samples,
                                              bool measures_first, bool has_standard_errors,
                                              double largest_input) {
  RemoteRobot::Options options;
  options.stages = bits_of(slots);
  options.sends_frames = sends_frames;
  options.sends_samples = sends_samples;
  options.measures_first = measures_first;
  options.has_standard_errors = has_standard_errors;
  options.largest_input = largest_input;
  const auto world = std::dynamic_pointer_cast<SimulatedWorld>(any_world);
  if (!world) throw py::type_error("world must be a SimulatedWorld");
  for (const Image& image : world->frame_memory()) options.memory.push_back(image.row(0));
  options.choose_memory = [world](std::size_t slot) { world->choose_frame_memory(slot); };
  return std::make_shared<PythonRemoteRobot>(std::move(options), exchange, refuse);
}

std::shared_ptr<PythonRemoteWorld> make_remote_world(
    const py::object& exchange, const std::vector<StageBit>& slots,
    const std::optional<std::shared_ptr<SharedFrames>>& frames, std::pair<int, int> resolution) {
  RemoteWorld::Options options;
  options.stages = bits_of(slots);
  options.frames = frames.value_or(nullptr);
  options.width = resolution.first;
  options.height = resolution.second;
  return std::make_shared<PythonRemoteWorld>(options, exchange);
}

// Called without the interpreter.
void handle_signals() {
  const py::gil_scoped_acquire interpreter;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

MessageSocket make_socket(int descriptor, const py::object& limits) {
  return MessageSocket(descriptor, limits.cast<MessageSocket::Limits>(), &handle_signals);
}

// The content of objects with a buffer; `buffers` keeps it alive.
std::vector<std::string_view> bytes_of(const py::object& parts,
                                       std::vector<py::buffer_info>& buffers) {
  std::vector<std::string_view> bytes;
  for (const py::handle part : parts) {
    const py::buffer_info& buffer = buffers.emplace_back(py::cast<py::buffer>(part).request());
    if (!PyBuffer_IsContiguous(buffer.view(), 'C')) throw py::value_error("a part with gaps");
    bytes.emplace_back(static_cast<const char*>(buffer.ptr),
                       static_cast<std::size_t>(buffer.size * buffer.itemsize));
  }
  return bytes;
}

// Raises what Python's own sockets raise.
template <typename Speak>
auto spoken(Speak speak) {
  try {
    const WithoutInterpreter others_go_on;
    return speak();
  } catch (const MessageTimeout& error) {
    PyErr_SetString(PyExc_TimeoutError, error.what());
  } catch (const ConnectionEnd& error) {
    PyErr_SetString(PyExc_EOFError, error.what());
  } catch (const WrongMessage& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  } catch (const std::system_error& error) {
    errno = error.code().value();
    PyErr_SetFromErrno(PyExc_OSError);
  }
  throw py::error_already_set();
}

// Sends a message of these parts; returns the next one.
std::pair<int, py::bytes> exchanged(MessageSocket& socket, int kind, const py::object& parts,
                                    double patience) {
  std::vector<py::buffer_info> buffers;
  const std::vector<std::string_view> bytes = bytes_of(parts, buffers);
  const MessageSocket::Message message = spoken([&] {
    socket.send(static_cast<std::uint16_t>(kind), bytes, patience);
    return socket.receive(patience);
  });
  return {message.kind, py::bytes(message.body.data(), message.body.size())};
}

}  // namespace

void bind_remote(py::module_& module) {
  Class<MessageSocket>(
      public_in(module, "robsim._core"), "MessageSocket",
      "One end of a stream socket between two processes that send messages in turn.")
      .def(py::init(&make_socket), "descriptor"_a, "limits"_a)
      .def("exchange", &exchanged, "kind"_a, "parts"_a, "patience"_a);

  Class<PythonRemoteRobot, std::shared_ptr<PythonRemoteRobot>>(
      public_in(module, "robsim._core"), "RemoteRobot",
      "A robot half in another process: a value for its slots. exchange(message, pixels or None, "
      "slot, k) returns the answer; refuse(slot, k, what) raises.",
      py::custom_type_setup(&collect_garbage<PythonRemoteRobot>))
      .def(py::init(&make_robot), "exchange"_a, "refuse"_a, py::kw_only(), "slots"_a, "world"_a,
           "sends_frames"_a, "sends_samples"_a, "measures_first"_a, "has_standard_errors"_a,
           "largest_input"_a);

  Class<SharedFrames, std::shared_ptr<SharedFrames>>(
      public_in(module, "robsim._core"), "SharedFrames",
      "Frames in memory that another process writes, mapped read-only.")
      .def(py::init([](int descriptor, int slots, std::size_t slot_bytes,
                       std::pair<int, int> resolution) {
             return std::make_shared<SharedFrames>(descriptor, slots, slot_bytes, resolution.first,
                                                   resolution.second);
           }),
           "descriptor"_a, "slots"_a, "slot_bytes"_a, "resolution"_a);

  Class<PythonRemoteWorld, World, std::shared_ptr<PythonRemoteWorld>>(
      public_in(module, "robsim._core"), "RemoteWorld",
      "The world half in another process: exchange(answer) sends the answer, unless it is empty, "
      "and returns the next message, None at the end.",
      py::custom_type_setup(&collect_garbage<PythonRemoteWorld>))
      .def(py::init(&make_remote_world), "exchange"_a, py::kw_only(), "slots"_a, "frames"_a,
           "resolution"_a);
}
