#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "robsim/imaging/raw/pixel_format.hpp"
#include "robsim/lab/capture/capture_device.hpp"
#include "robsim/lab/capture/gige/gige_vision.hpp"
#include "robsim/lab/capture/gige/settings.hpp"

namespace robsim {

struct GigeCameraOptions {
  std::string source;  // IPv4 address, host name, serial number or user-defined name
  GigeSettings settings;
  int packet_size = 0;  // bytes; 0: the largest one that comes through
};

/// What an open camera is, and how it is set.
struct GigeInfo {
  GigeIdentity identity;
  std::string format;
  SensorRegion region;
  std::string coding;
  double fps = 0;  // 1/s; 0: unknown
  int packet_size = 0;
  std::string advice;  // empty: there is none
};

/// A GigE Vision camera, read by Aravis.
class GigeCamera : public CaptureDevice {
 public:
  explicit GigeCamera(GigeCameraOptions options);
  ~GigeCamera() override { close(); }

  void open() override;
  std::optional<Captured> next(ImagePool& pool) override;
  void close() noexcept override;

  // For any thread:

  /// Nothing before it is open for the first time.
  std::optional<GigeInfo> info() const;

  /// How its features are set. What is set holds when it is opened again, too. Throws CaptureError,
  /// also if it is not open.
  std::vector<FeatureState> features() const;
  void set_features(const std::vector<FeatureWish>& wishes);

 private:
  GigeIdentity find() const;
  void open_at(const GigeIdentity& identity);
  void connect(const GigeIdentity& identity);
  void choose_packet_size(const GigeIdentity& identity);
  void prepare();
  void tell(const GigeIdentity& identity);
  void start();
  void count(ArvBuffer* buffer, Captured& captured);
  Captured captured(ArvBuffer* buffer, ImagePool& pool);
  RawView view_of(ArvBuffer* buffer);
  ArvCamera* camera() const;
  void give_back() noexcept;

  const GigeCameraOptions options_;
  GigeSettings settings_;  // with the features that have been set since
  const std::string name_;
  GReference<ArvCamera> camera_;
  GReference<ArvStream> stream_;
  std::string address_;
  std::shared_ptr<std::atomic<bool>> is_lost_;  // shared with a thread of Aravis
  std::size_t payload_ = 0;                     // bytes of a frame
  bool is_first_ = true;
  std::uint64_t last_id_ = 0;      // of the last complete frame; 0: none yet
  std::int64_t n_incomplete_ = 0;  // counted since then

  mutable std::mutex mutex_;  // of the registers
  std::optional<GigeInfo> info_;
};

}  // namespace robsim
