#include "robsim/lab/capture/gige/gige_camera.hpp"

#include <algorithm>
#include <fstream>
#include <thread>
#include <utility>

#include "robsim/base/system.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"
#include "robsim/lab/capture/gige/aravis.hpp"
#include "robsim/lab/capture/gige/gige_vision.hpp"

namespace robsim {

namespace {

constexpr double patience_for_answer = 0.5;   // s; a camera answers within milliseconds
constexpr double patience_for_discovery = 1;  // s
constexpr int most_attempts = 3;
constexpr guint64 patience_for_frame = 100'000;  // us
constexpr int local_packet = 16000;  // bytes: on loopback the fewer there are, the fewer are lost
constexpr int safe_packet = 1500;    // bytes, of any Ethernet
constexpr std::size_t largest_payload = 256u << 20;   // bytes; more than any such camera has
constexpr std::size_t memory_of_buffers = 64u << 20;  // bytes
constexpr std::size_t least_receive_buffer = 4u << 20, most_receive_buffer = 64u << 20;  // bytes

[[noreturn]] void fail(CaptureFault fault, const std::string& text) {
  throw CaptureError(fault, text);
}

[[noreturn]] void fail_busy(const std::string& name, const std::string& reason = "") {
  fail(CaptureFault::busy, name + ": another program has the camera" + reason +
                               ": close it there; the camera lets go of one that crashed after "
                               "some seconds");
}

// Errors while a camera is opened.
[[noreturn]] void fail(const std::string& name, const GFailure& failure) {
  if (failure.is(ARV_DEVICE_ERROR_NOT_CONTROLLER) ||
      failure.is(ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED) ||
      failure.is(ARV_DEVICE_ERROR_PROTOCOL_ERROR_BUSY)) {
    fail_busy(name, " (" + failure.text() + ")");
  }
  if (failure.is(ARV_DEVICE_ERROR_TIMEOUT) || failure.is(ARV_DEVICE_ERROR_NOT_FOUND)) {
    fail(CaptureFault::no_camera, name + " has stopped answering (" + failure.text() + ")");
  }
  fail(CaptureFault::failed, name + " cannot be opened: " + failure.text());
}

std::optional<long> largest_receive_buffer() {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  long bytes = 0;
  return file >> bytes ? std::optional(bytes) : std::nullopt;
}

std::string advice_on(std::size_t payload) {
  const std::optional<long> largest = largest_receive_buffer();
  // Linux counts its own administration of each packet, too.
  if (!largest || *largest >= static_cast<long>(payload + payload / 2)) return "";
  const std::string wanted = std::to_string(std::max(4 * payload, least_receive_buffer));
  return "the system's receive buffer of " + std::to_string(*largest) +
         " bytes is small for frames of " + std::to_string(payload) +
         " bytes: sudo sysctl -w net.core.rmem_max=" + wanted;
}

GReference<GInetAddress> inet_address(const std::string& text) {
  return GReference<GInetAddress>(g_inet_address_new_from_string(text.c_str()));
}

bool is_local(const GigeIdentity& identity) {
  return identity.address == identity.interface_address || identity.address.rfind("127.", 0) == 0;
}

// A flag that is set when the control of a device is lost. It lives as long as either.
std::shared_ptr<std::atomic<bool>> watch_control(ArvDevice* device) {
  using Flag = std::shared_ptr<std::atomic<bool>>;
  Flag is_lost = std::make_shared<std::atomic<bool>>(false);
  const auto set = +[](ArvDevice*, gpointer flag) { **static_cast<Flag*>(flag) = true; };
  const auto release = +[](gpointer flag, GClosure*) { delete static_cast<Flag*>(flag); };
  g_signal_connect_data(device, "control-lost", G_CALLBACK(set), new Flag(is_lost), release,
                        GConnectFlags(0));
  return is_lost;
}

// A buffer of a stream, which gets it back.
struct GivenBack {
  ArvStream* stream;
  void operator()(ArvBuffer* buffer) const { arv_stream_push_buffer(stream, buffer); }
};
using Lent = std::unique_ptr<ArvBuffer, GivenBack>;

// Aravis calls a frame complete that has fewer bytes than its size needs.
bool is_complete(ArvBuffer* buffer) {
  if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS ||
      arv_buffer_get_payload_type(buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE) {
    return false;
  }
  const PixelFormat* const format = pixel_format_of(arv_buffer_get_image_pixel_format(buffer));
  std::size_t bytes = 0;
  arv_buffer_get_data(buffer, &bytes);
  const double width = arv_buffer_get_image_width(buffer);  // may be any number
  const double bits = format ? width * arv_buffer_get_image_height(buffer) * format->bits : 0;
  return 8.0 * static_cast<double>(bytes) >= bits;
}

}  // namespace

GigeCamera::GigeCamera(GigeCameraOptions options)
    : options_(std::move(options)),
      settings_(options_.settings),
      name_("GigE camera " + options_.source),
      is_lost_(std::make_shared<std::atomic<bool>>(false)) {}

std::optional<GigeInfo> GigeCamera::info() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return info_;
}

ArvCamera* GigeCamera::camera() const {
  if (!camera_) fail(CaptureFault::failed, name_ + " is not open");
  return camera_.get();
}

std::vector<FeatureState> GigeCamera::features() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return gige::features_of(camera());
}

void GigeCamera::set_features(const std::vector<FeatureWish>& wishes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::vector<FeatureWish> all = overlaid(settings_.features, wishes);
  gige::set_features(camera(), all);
  settings_.features = all;
}

void GigeCamera::open() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stream_) return;
  give_back();
  const GigeIdentity identity = find();
  // A program that is held up on a busy machine loses the camera again before it has started it.
  for (int attempts_left = most_attempts - 1;; --attempts_left) {
    try {
      return open_at(identity);
    } catch (const CaptureError& error) {
      const bool was_ours = camera_ != nullptr;
      if (error.fault() != CaptureFault::busy || !was_ours || attempts_left == 0) throw;
      give_back();
    }
  }
}

void GigeCamera::open_at(const GigeIdentity& identity) {
  try {
    connect(identity);
    apply(settings_, camera_.get(), name_);
    choose_packet_size(identity);
    prepare();
    tell(identity);
    start();
  } catch (const CaptureError& error) {
    if (error.fault() != CaptureFault::failed) throw;
    if (ask_gige_camera(identity.address, patience_for_answer)) throw;
    fail(CaptureFault::unplugged, name_ + " has stopped answering while it was opened");
  }
}

GigeIdentity GigeCamera::find() const {
  const std::string& source = options_.source;
  std::string others;
  if (!is_ipv4_address(source)) {
    for (const GigeIdentity& one : find_gige_cameras(patience_for_discovery)) {
      if (one.serial == source || one.user_name == source) return one;
      others += (others.empty() ? "" : ", ") + one.serial + " at " + one.address;
    }
  }
  if (const auto identity = ask_gige_camera(source, patience_for_answer)) return *identity;
  fail(CaptureFault::no_camera,
       "no GigE Vision camera answers at " + source +
           ": is it on, is the address right, and in "
           "the network of this computer? " +
           (others.empty() ? "robsim cameras --network looks for all" : "Found: " + others));
}

void GigeCamera::connect(const GigeIdentity& identity) {
  GFailure failure;
  const GReference<GInetAddress> interface = inet_address(identity.interface_address);
  const GReference<GInetAddress> address = inet_address(identity.address);
  GReference<ArvDevice> device(arv_gv_device_new(interface.get(), address.get(), failure.out()));
  if (!device || failure) fail(name_, failure);
  if (!arv_gv_device_is_controller(ARV_GV_DEVICE(device.get()))) {
    // It waits for leave to give back what it never had.
    start_thread([left = device.release()] { g_object_unref(left); }).detach();
    fail_busy(name_);
  }
  is_lost_ = watch_control(device.get());
  address_ = identity.address;
  camera_.reset(arv_camera_new_with_device(device.get(), failure.out()));
  if (!camera_ || failure) fail(name_, failure);
}

void GigeCamera::choose_packet_size(const GigeIdentity& identity) {
  ArvCamera* const camera = camera_.get();
  const bool can_test = ARV_IS_GC_NODE(
      arv_device_get_feature(arv_camera_get_device(camera), "GevSCPSFireTestPacket"));
  GFailure failure;
  if (options_.packet_size > 0) {
    arv_camera_gv_set_packet_size(camera, options_.packet_size, failure.out());
  } else if (can_test) {
    arv_camera_gv_auto_packet_size(camera, failure.out());
  } else if (is_local(identity)) {
    arv_camera_gv_set_packet_size(camera, local_packet, failure.out());
  } else if (arv_camera_gv_get_packet_size(camera, failure.out()) > safe_packet) {
    arv_camera_gv_set_packet_size(camera, safe_packet, failure.out());
  }
  if (failure) fail(name_, failure);
  // It is chosen: the stream is not to try again.
  arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
  // A packet socket, which Aravis takes where it is allowed to, gets nothing on loopback.
  arv_camera_gv_set_stream_options(camera, is_local(identity)
                                               ? ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED
                                               : ARV_GV_STREAM_OPTION_NONE);
}

void GigeCamera::prepare() {
  GFailure failure;
  payload_ = arv_camera_get_payload(camera_.get(), failure.out());
  if (failure) fail(name_, failure);
  if (payload_ == 0 || payload_ > largest_payload) {  // Aravis ends the program without memory
    fail(CaptureFault::failed, name_ + " tells of frames of " + std::to_string(payload_) +
                                   " bytes, and 1 to " + std::to_string(largest_payload) +
                                   " are read: choose a smaller size");
  }
  stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, failure.out()));
  if (!stream_ || failure) fail(name_, failure);
  // In part what the system allows: it takes less without a word.
  const auto room =
      static_cast<gint>(std::clamp(4 * payload_, least_receive_buffer, most_receive_buffer));
  g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
               "socket-buffer-size", room, nullptr);
  const std::size_t n_buffers = std::clamp<std::size_t>(memory_of_buffers / payload_, 4, 16);
  for (std::size_t i = 0; i < n_buffers; ++i) {
    arv_stream_push_buffer(stream_.get(), arv_buffer_new(payload_, nullptr));
  }
  is_first_ = true;
  last_id_ = 0;
  n_incomplete_ = 0;
}

void GigeCamera::start() {
  GFailure failure;
  arv_camera_start_acquisition(camera_.get(), failure.out());
  if (failure) fail(name_, failure);
}

void GigeCamera::tell(const GigeIdentity& identity) {
  ArvCamera* const camera = camera_.get();
  GigeInfo info;
  info.identity = identity;
  const char* const format = arv_camera_get_pixel_format_as_string(camera, GFailure().out());
  info.format = format ? format : "";
  const auto* const known = pixel_format_of(arv_camera_get_pixel_format(camera, GFailure().out()));
  if (known) info.coding = known->coding;
  SensorRegion& region = info.region;
  arv_camera_get_region(camera, &region.left, &region.top, &region.width, &region.height,
                        GFailure().out());
  info.fps = rate_of(camera);
  info.packet_size = static_cast<int>(arv_camera_gv_get_packet_size(camera, GFailure().out()));
  info.advice = advice_on(payload_);
  info_ = std::move(info);
}

std::optional<Captured> GigeCamera::next(ImagePool& pool) {
  if (!stream_ || *is_lost_) {
    fail(CaptureFault::unplugged, name_ + " answers no more: is it on, and its cable plugged in?");
  }
  ArvStream* const stream = stream_.get();
  Lent newest(nullptr, {stream});
  Captured before;
  for (ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, patience_for_frame); buffer;
       buffer = arv_stream_try_pop_buffer(stream)) {
    Lent one(buffer, {stream});
    count(buffer, before);
    if (!is_complete(buffer)) continue;
    before.passed += newest != nullptr;
    newest = std::move(one);
  }
  if (!newest) {
    if (before.torn == 0) return std::nullopt;
    --before.torn;  // it is this one
    before.is_complete = false;
    before.arrived = monotonic_now();
    return before;
  }
  Captured captured = this->captured(newest.get(), pool);
  captured.passed = before.passed;
  captured.torn = before.torn;
  return captured;
}

// Counts what is torn, and what has not come: of incomplete frames the number may be missing, too.
void GigeCamera::count(ArvBuffer* buffer, Captured& captured) {
  const bool is_first = std::exchange(is_first_, false);
  if (!is_complete(buffer)) {
    // The first frame after the start may have begun before it.
    if (is_first) return;
    ++n_incomplete_;
    ++captured.torn;
    return;
  }
  const std::uint64_t id = arv_buffer_get_frame_id(buffer);
  const std::int64_t n_lost = last_id_ == 0 ? 0 : lost_between(last_id_, id);
  captured.torn += std::max<std::int64_t>(n_lost - n_incomplete_, 0);
  n_incomplete_ = 0;
  last_id_ = id;
}

Captured GigeCamera::captured(ArvBuffer* buffer, ImagePool& pool) {
  Captured captured;
  captured.arrived = monotonic_now();
  const guint64 device_time = arv_buffer_get_timestamp(buffer);
  if (device_time > 0) captured.device_time = 1e-9 * static_cast<double>(device_time);
  const RawView raw = view_of(buffer);
  captured.image = pool.take(raw.width, raw.height);
  to_rgb(raw, captured.image.writable_view());
  return captured;
}

// The first packet of a frame tells its size and format, whatever has come of it.
RawView GigeCamera::view_of(ArvBuffer* buffer) {
  const PixelFormat* const format = pixel_format_of(arv_buffer_get_image_pixel_format(buffer));
  if (!format) fail(CaptureFault::failed, name_ + " delivers frames of another pixel format");
  std::size_t size = 0;
  const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size));
  try {
    return raw_view(data, size, *format, arv_buffer_get_image_width(buffer),
                    arv_buffer_get_image_height(buffer));
  } catch (const std::invalid_argument& error) {
    fail(CaptureFault::failed, name_ + " delivers what is no frame: " + error.what());
  }
}

void GigeCamera::close() noexcept {
  const std::lock_guard<std::mutex> lock(mutex_);
  give_back();
}

void GigeCamera::give_back() noexcept {
  if (!camera_) return;
  const bool is_there = !*is_lost_ && ask_gige_camera(address_, patience_for_answer).has_value();
  const auto end = [is_there, stream = stream_.release(), camera = camera_.release()] {
    if (is_there && stream) arv_camera_stop_acquisition(camera, GFailure().out());
    if (stream) g_object_unref(stream);
    g_object_unref(camera);
  };
  // Aravis waits seconds for answers of a camera that is gone, and nobody needs to wait for that.
  is_there ? end() : start_thread(end).detach();
}

}  // namespace robsim
