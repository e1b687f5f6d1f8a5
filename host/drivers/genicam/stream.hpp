// The frames that a camera sends, into buffers of this program's own: Aravis' thread fills them, asks for
// missing packets again and tells by a descriptor when one is done. One thread's, beside Aravis'.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/drivers/genicam/camera.hpp"
#include "host/drivers/genicam/frame_file.hpp"

typedef struct _ArvStream ArvStream;
typedef struct _ArvBuffer ArvBuffer;

namespace strobe::genicam {

struct Received {
  std::string why_lost;                   ///< empty: it is complete
  std::optional<std::uint64_t> block_id;  ///< GigE Vision's; nullopt: its first packet is missing
  std::optional<std::int64_t> stamp_ns;   ///< the camera's clock, where it has one
  WallTime begun;                         ///< when its first packet came, just after the exposure
  std::int64_t packets_resent = 0;
  Frame frame;  ///< of a complete one
};

class Stream {
 public:
  /// Of payloads no larger than that of the largest photograph.
  static constexpr std::int64_t kMaxPayload_bytes = 256 << 20;

  /// payload_bytes: of one frame, as the camera says. Finds out how large packets may be, unless told to keep
  /// their size. The camera outlives the stream.
  static Result<std::unique_ptr<Stream>> create(Camera& camera, std::int64_t payload_bytes,
                                                bool keep_packet_size);
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Readable when there is one.
  int descriptor() const { return event_; }
  /// The next one that is done; its bytes are valid until the next call. Never waits.
  std::optional<Received> next();
  /// Whether there is one.
  bool waits();

 private:
  struct Done {
    ArvBuffer* buffer = nullptr;
    std::int64_t packets_resent = 0;
  };
  Stream();
  static void on_event(void* self, int type, ArvBuffer* buffer);
  void give(ArvBuffer* buffer);
  Received received(const Done& done) const;
  Frame frame_of(ArvBuffer* buffer) const;

  std::size_t payload_bytes_ = 0;
  std::vector<std::unique_ptr<std::uint8_t[]>> memory_;
  int event_ = -1;
  std::mutex mutex_;
  std::deque<Done> done_;         ///< guarded by the mutex
  std::uint64_t resent_ = 0;      ///< before the newest; Aravis' thread's
  ArvStream* running_ = nullptr;  ///< for that thread; guarded by the mutex
  ArvBuffer* lent_ = nullptr;     ///< of the last Received
  Owned<ArvStream> stream_;       ///< ends first
};

}  // namespace strobe::genicam
