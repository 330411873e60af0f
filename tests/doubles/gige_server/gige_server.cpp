#include "gige_server/gige_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "raw/from_rgb.hpp"
#include "robsim/base/system.hpp"
#include "robsim/lab/capture/gige/aravis.hpp"
#include "robsim/lab/capture/gige/gige_vision.hpp"

namespace robsim {

namespace {

constexpr std::size_t most_waiting = 3;    // frames: more would only be older
constexpr double longest_wait = 0.1;       // s in which the fake camera answers no client
constexpr double fresh = 0.2;              // periods of age
constexpr double replug_interval = 0.1;    // s
constexpr double usual_exposure = 10'000;  // us
const char* const lost_packets = "gvsp-lost-ratio";
constexpr double torn_part = 0.5;  // of the packets

using Seconds = std::chrono::duration<double>;
using Lock = std::unique_lock<std::mutex>;

// The socket of a question to a camera, or of the camera itself, and the camera's address.
struct Control {
  explicit Control(const std::string& text) {
    address.sin_family = AF_INET;
    address.sin_port = htons(gvcp_port);
    inet_pton(AF_INET, text.c_str(), &address.sin_addr);
  }
  ~Control() { close(descriptor); }
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  const sockaddr* to() const { return reinterpret_cast<const sockaddr*>(&address); }

  int descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
};

// The fake camera of Aravis would go on in silence if the port is taken.
void check_port(const std::string& text) {
  const Control camera(text);
  if (bind(camera.descriptor, camera.to(), sizeof camera.address) != 0) {
    throw std::runtime_error(text + " serves no camera: " + std::strerror(errno));
  }
}

// Asks the camera what it is, and does not wait for what it says.
void knock(const std::string& text) {
  constexpr std::array<std::uint8_t, 8> question{0x42, 0x01, 0, 2, 0, 0, 0, 1};
  const Control camera(text);
  static_cast<void>(sendto(camera.descriptor, question.data(), question.size(), 0, camera.to(),
                           sizeof camera.address));
}

// The part of an image that a client has chosen, moved into it where it does not lie in it.
ImageView part_of(const ImageView& image, int left, int top, int width, int height) {
  const int u = std::clamp(left, 0, image.width - width);
  const int v = std::clamp(top, 0, image.height - height);
  return {image.row(v) + 3 * u, width, height, image.stride};
}

void brighten(std::uint8_t* data, std::size_t size, double factor) {
  std::array<std::uint8_t, 256> bright;
  for (std::size_t value = 0; value < bright.size(); ++value) {
    bright[value] = static_cast<std::uint8_t>(
        std::clamp(std::lround(factor * static_cast<double>(value)), 0L, 255L));
  }
  std::transform(data, data + size, data, [&](std::uint8_t x) { return bright[x]; });
}

void write_register(ArvFakeCamera* camera, guint32 address, double value) {
  arv_fake_camera_write_register(camera, address, static_cast<guint32>(std::lround(value)));
}

}  // namespace

GigeServer::GigeServer(std::shared_ptr<CaptureDevice> device, GigeServerOptions options)
    : device_(std::move(device)), options_(std::move(options)) {
  plug_in();
  thread_ = start_thread([this] { run(); });
}

std::string GigeServer::failure() const {
  const Lock lock(mutex_);
  return failure_;
}

void GigeServer::plug_in() {
  check_port(options_.address);
  {
    const Lock lock(mutex_);
    ends_ = false;
    waiting_.clear();
  }
  std::thread starter = start_thread([this] {  // its thread inherits that no signal comes to it
    camera_.reset(arv_gv_fake_camera_new(options_.address.c_str(), options_.serial.c_str()));
  });
  starter.join();
  if (!camera_ || !arv_gv_fake_camera_is_running(camera_.get())) {
    throw std::runtime_error("the fake camera of Aravis does not run");
  }
  ArvFakeCamera* const camera = arv_gv_fake_camera_get_fake_camera(camera_.get());
  write_register(camera, ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, options_.width);
  write_register(camera, ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, options_.height);
  write_register(camera, ARV_FAKE_CAMERA_REGISTER_WIDTH, options_.width);
  write_register(camera, ARV_FAKE_CAMERA_REGISTER_HEIGHT, options_.height);
  write_register(camera, ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, ARV_PIXEL_FORMAT_RGB_8_PACKED);
  write_register(camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 1e6 / options_.fps);
#if ARAVIS_CHECK_VERSION(0, 9, 0)
  arv_fake_camera_set_fill_pattern(camera, &GigeServer::fill, this, nullptr);
#else
  arv_fake_camera_set_fill_pattern(camera, &GigeServer::fill, this);
#endif
}

void GigeServer::plug_out() {
  {
    const Lock lock(mutex_);
    if (!camera_) return;
    ends_ = true;
    g_object_set(camera_.get(), lost_packets, 1.0, nullptr);
    changed_.notify_all();
  }
  camera_.reset();
}

// False if the camera ends, which must not be touched any more: all is lost then.
bool GigeServer::lose(double part) {
  const Lock lock(mutex_);
  if (!ends_) g_object_set(camera_.get(), lost_packets, part, nullptr);
  return !ends_;
}

bool GigeServer::pause(double seconds) {
  Lock lock(mutex_);
  return changed_.wait_for(lock, Seconds(seconds), [&] { return stops_; });
}

void GigeServer::run() {
  try {
    pump();
  } catch (const std::exception& error) {
    const Lock lock(mutex_);
    failure_ = error.what();
  }
  device_->close();
  plug_out();
}

// Until it is told to stop. The camera on the network comes and goes with the one that it shows.
void GigeServer::pump() {
  bool is_open = false;
  while (!pause(0)) {
    try {
      if (!is_open) {
        device_->open();
        is_open = true;
        if (!camera_) plug_in();
      }
      if (std::optional<Captured> captured = device_->next(pool_)) take(std::move(*captured));
    } catch (const CaptureError& error) {
      if (error.fault() == CaptureFault::time_out) continue;
      const bool is_away =
          error.fault() == CaptureFault::unplugged || error.fault() == CaptureFault::no_camera;
      if (!is_away) throw;
      is_open = false;
      device_->close();
      plug_out();
      pause(replug_interval);
    }
  }
}

void GigeServer::take(Captured captured) {
  bool must_wake = false;
  {
    const Lock lock(mutex_);
    waiting_.push_back(std::move(captured));
    if (waiting_.size() > most_waiting) waiting_.pop_front();
    changed_.notify_all();
    must_wake = !is_awaited_ && has_client();
  }
  // If its time for a frame passes while the fake camera looks at the clock, it subtracts without
  // a sign, and sleeps for 0.1 s. A question wakes it.
  if (must_wake) knock(options_.address);
}

// With the mutex.
bool GigeServer::has_client() const {
  return monotonic_now() - last_fill_ < 2 / options_.fps + longest_wait;
}

void GigeServer::fill(ArvBuffer* buffer, void* server, guint32 exposure, guint32 gain,
                      ArvPixelFormat format) {
  const double brightness = exposure / usual_exposure * std::pow(10.0, gain / 20.0);
  auto* const self = static_cast<GigeServer*>(server);
  try {
    self->fill(buffer, format, brightness);
  } catch (const std::exception&) {  // nothing may be thrown through Aravis
    self->lose(1);
  }
}

// Called by the fake camera once a period, and it sends what is there: what nobody is to see must
// be lost.
void GigeServer::fill(ArvBuffer* buffer, ArvPixelFormat code, double brightness) {
  const std::optional<Captured> next = wait_for_next();
  const int width = arv_buffer_get_image_width(buffer);
  const int height = arv_buffer_get_image_height(buffer);
  const PixelFormat* const format = pixel_format_of(code);
  const bool is_served =
      next && format && width <= next->image.width() && height <= next->image.height();
  if (!lose(!is_served ? 1 : next->is_complete ? 0 : torn_part) || !is_served) return;
  // The size that it tells is 0: the room is that of the frame.
  std::size_t ignored = 0;
  auto* const data =
      static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &ignored)));
  from_rgb(part_of(next->image.view(), arv_buffer_get_image_x(buffer),
                   arv_buffer_get_image_y(buffer), width, height),
           *format, data);
  if (brightness != 1) brighten(data, bytes_of(*format, width, height), brightness);
  if (next->device_time) {
    arv_buffer_set_timestamp(buffer, static_cast<guint64>(std::llround(1e9 * *next->device_time)));
  }
  if (next->is_complete) ++sent_;
}

std::optional<Captured> GigeServer::wait_for_next() {
  Lock lock(mutex_);
  const double period = 1 / options_.fps;
  // Nobody was there to see those from before.
  const bool is_new = !has_client();
  while (is_new && waiting_.size() > 1) waiting_.pop_front();
  is_awaited_ = true;
  changed_.wait_for(lock, Seconds(std::min(period, longest_wait)),
                    [&] { return ends_ || !waiting_.empty(); });
  is_awaited_ = false;
  last_fill_ = monotonic_now();
  if (ends_ || waiting_.empty()) return std::nullopt;
  Captured next = std::move(waiting_.front());
  waiting_.pop_front();
  // The rate is that of the world, whatever the client asks for. Who is behind is called sooner,
  // until it is there before the frame.
  const bool is_behind = !waiting_.empty() || last_fill_ - next.arrived > fresh * period;
  write_register(arv_gv_fake_camera_get_fake_camera(camera_.get()),
                 ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                 1e6 * period / (is_behind ? 2 : 1));
  return next;
}

void GigeServer::close() noexcept {
  if (!thread_.joinable()) return;
  {
    const Lock lock(mutex_);
    stops_ = true;
    changed_.notify_all();
  }
  device_->interrupt();
  thread_.join();
}

}  // namespace robsim
