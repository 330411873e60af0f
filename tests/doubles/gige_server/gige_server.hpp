#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "robsim/lab/capture/capture_device.hpp"
#include "robsim/lab/capture/gige/aravis.hpp"

namespace robsim {

struct GigeServerOptions {
  std::string address = "127.0.0.1";  // of an interface of this computer
  std::string serial;
  int width = 0, height = 0;  // of the frames, px
  double fps = 0;             // 1/s
};

/// Makes a camera of any kind a GigE Vision camera, by the fake camera of Aravis: it has the
/// registers and speaks the protocol, and what it sends are our frames. Each goes out once, in
/// order, as soon as it comes. A torn frame goes out with packets missing; while the camera is
/// unplugged nobody answers.
///
/// Brightness follows the exposure and the gain that the client sets: 10 ms and 0 dB change
/// nothing.
class GigeServer {
 public:
  /// Throws std::runtime_error if the address is taken. Frames have at most 2048 px a side.
  GigeServer(std::shared_ptr<CaptureDevice> device, GigeServerOptions options);
  ~GigeServer() { close(); }
  GigeServer(const GigeServer&) = delete;
  GigeServer& operator=(const GigeServer&) = delete;

  /// Frames that went out to a client.
  std::int64_t sent() const { return sent_; }

  /// Why it has ended by itself; empty: it has not.
  std::string failure() const;

  void close() noexcept;

 private:
  void run();
  void pump();
  void plug_in();
  void plug_out();
  bool lose(double part);
  std::optional<Captured> wait_for_next();
  bool has_client() const;
  void take(Captured captured);
  static void fill(ArvBuffer* buffer, void* server, guint32 exposure, guint32 gain,
                   ArvPixelFormat format);
  void fill(ArvBuffer* buffer, ArvPixelFormat code, double brightness);
  bool pause(double seconds);

  const std::shared_ptr<CaptureDevice> device_;
  const GigeServerOptions options_;
  GReference<ArvGvFakeCamera> camera_;  // of the pumping thread, and of its own
  ImagePool pool_;                      // of the pumping thread
  std::atomic<std::int64_t> sent_{0};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Under the mutex:
  std::deque<Captured> waiting_;
  double last_fill_ = 0;     // monotonic, s
  bool is_awaited_ = false;  // the next frame
  std::string failure_;
  bool stops_ = false;
  bool ends_ = false;  // the camera on the network does

  std::thread thread_;
};

}  // namespace robsim
