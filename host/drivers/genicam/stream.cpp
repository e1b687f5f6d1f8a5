#include "host/drivers/genicam/stream.hpp"

#include <arv.h>
#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "host/drivers/genicam/stamp_latch.hpp"

namespace strobe::genicam {
namespace {

// So many frames may wait for being written.
constexpr std::int64_t kMinBuffers = 3, kMaxBuffers = 50;
constexpr std::int64_t kBuffers_bytes = 384 << 20;
constexpr std::int64_t kMinSocket_bytes = 1 << 20;
// What a buffer is marked with until the first packet of its frame has come.
constexpr std::uint64_t kNoBlock = std::numeric_limits<std::uint64_t>::max();
// A missing packet is asked for again so soon, and so often; a frame is waited for so long after its newest.
constexpr unsigned kPacketTimeout_us = 5000, kFrameRetention_us = 500'000;
constexpr double kMaxRequestsPerPacket = 1.0;

std::string words(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return "";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "the frame is incomplete: packets did not come, nor when asked for again";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "the frame is incomplete: packets are missing";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "the frame has packets that it cannot have";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "the frame is larger than the camera said";
    case ARV_BUFFER_STATUS_ABORTED:
      return "the frame was broken off";
    default:
      return fmt::format("the frame has not come (status {})", static_cast<int>(status));
  }
}

}  // namespace

Stream::Stream() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

Stream::~Stream() {
  {
    const std::lock_guard lock(mutex_);
    running_ = nullptr;
  }
  if (lent_ != nullptr) g_object_unref(lent_);
  stream_.reset();
  if (event_ >= 0) close(event_);
}

Result<std::unique_ptr<Stream>> Stream::create(Camera& camera, std::int64_t payload_bytes,
                                               bool keep_packet_size) {
  if (payload_bytes <= 0 || payload_bytes > kMaxPayload_bytes)
    return fail(fmt::format("the camera says that a frame has {} bytes: up to {} are taken", payload_bytes,
                            kMaxPayload_bytes));
  std::unique_ptr<Stream> stream(new Stream);
  // The largest packets that the network carries are the fewest.
  if (camera.is_gige() && !keep_packet_size)
    arv_camera_gv_set_packet_size_adjustment(camera.aravis(), ARV_GV_PACKET_SIZE_ADJUSTMENT_ONCE);
  GError* error = nullptr;
  const ArvStreamCallback on_event = [](void* self, ArvStreamCallbackType type, ArvBuffer* buffer) {
    Stream::on_event(self, type, buffer);
  };
  stream->stream_.reset(arv_camera_create_stream(camera.aravis(), on_event, stream.get(), &error));
  if (!stream->stream_) {
    std::string why = error != nullptr ? error->message : "no reason given";
    g_clear_error(&error);
    return fail("frames cannot be received: " + why);
  }
  if (ARV_IS_GV_STREAM(stream->stream_.get())) {
    // As the kernel counts, which gives no more than net.core.rmem_max; a packet costs it twice its bytes.
    const auto socket_bytes = static_cast<int>(std::max(2 * payload_bytes, kMinSocket_bytes));
    g_object_set(stream->stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                 "socket-buffer-size", socket_bytes, "packet-timeout", kPacketTimeout_us, "frame-retention",
                 kFrameRetention_us, "packet-request-ratio", kMaxRequestsPerPacket, nullptr);
  }
  stream->payload_bytes_ = static_cast<std::size_t>(payload_bytes);
  const auto count = std::clamp(kBuffers_bytes / payload_bytes, kMinBuffers, kMaxBuffers);
  for (std::int64_t i = 0; i < count; ++i) {
    stream->memory_.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(stream->payload_bytes_));
    stream->give(arv_buffer_new(stream->payload_bytes_, stream->memory_.back().get()));
  }
  const std::lock_guard lock(stream->mutex_);
  stream->running_ = stream->stream_.get();
  return stream;
}

/// Marked, since Aravis leaves in it what the frame before said where this one's first packet is missing.
void Stream::give(ArvBuffer* buffer) {
  arv_buffer_set_frame_id(buffer, kNoBlock);
  arv_buffer_set_timestamp(buffer, 0);
  arv_buffer_set_system_timestamp(buffer, 0);
  arv_stream_push_buffer(stream_.get(), buffer);
}

void Stream::on_event(void* self, int type, ArvBuffer* buffer) {
  if (type != ARV_STREAM_CALLBACK_TYPE_BUFFER_DONE || buffer == nullptr) return;
  auto& stream = *static_cast<Stream*>(self);
  const std::lock_guard lock(stream.mutex_);
  if (stream.running_ == nullptr) return;
  const std::uint64_t resent = ARV_IS_GV_STREAM(stream.running_)
                                   ? arv_stream_get_info_uint64_by_name(stream.running_, "n_resent_packets")
                                   : 0;
  stream.done_.push_back({buffer, static_cast<std::int64_t>(resent - stream.resent_)});
  stream.resent_ = resent;
  const std::uint64_t one = 1;
  static_cast<void>(!write(stream.event_, &one, sizeof one));
}

/// Aravis' own queue has the buffers in the order in which they were done.
std::optional<Received> Stream::next() {
  if (lent_ != nullptr) give(std::exchange(lent_, nullptr));
  std::uint64_t count = 0;
  static_cast<void>(!read(event_, &count, sizeof count));
  Done done;
  {
    const std::lock_guard lock(mutex_);
    if (done_.empty()) return std::nullopt;
    done = done_.front();
    done_.pop_front();
    const std::uint64_t one = 1;
    if (!done_.empty()) static_cast<void>(!write(event_, &one, sizeof one));
  }
  lent_ = arv_stream_try_pop_buffer(stream_.get());
  if (lent_ == nullptr) return std::nullopt;
  done.buffer = lent_;
  return received(done);
}

bool Stream::waits() {
  const std::lock_guard lock(mutex_);
  return !done_.empty();
}

Received Stream::received(const Done& done) const {
  Received received;
  received.why_lost = words(arv_buffer_get_status(done.buffer));
  received.packets_resent = done.packets_resent;
  const std::uint64_t block_id = arv_buffer_get_frame_id(done.buffer);
  const std::uint64_t stamp_ns = arv_buffer_get_timestamp(done.buffer);
  received.begun =
      WallTime{Duration{static_cast<std::int64_t>(arv_buffer_get_system_timestamp(done.buffer))}};
  if (block_id != kNoBlock) received.block_id = block_id;
  if (block_id != kNoBlock && stamp_ns > 0 && stamp_ns < kMaxStamp_ns)
    received.stamp_ns = static_cast<std::int64_t>(stamp_ns);
  if (!received.why_lost.empty()) return received;
  const ArvBufferPayloadType type = arv_buffer_get_payload_type(done.buffer);
  if (type == ARV_BUFFER_PAYLOAD_TYPE_IMAGE || type == ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA)
    received.frame = frame_of(done.buffer);
  else
    received.why_lost = fmt::format("the camera sent no image (payload type {})", static_cast<int>(type));
  return received;
}

/// No more bytes than came, and than there is memory for.
Frame Stream::frame_of(ArvBuffer* buffer) const {
  Frame frame;
  std::size_t size = 0;
  arv_buffer_get_image_data(buffer, &size);
  const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, nullptr));
  frame.pixel_format = arv_buffer_get_image_pixel_format(buffer);
  frame.width = arv_buffer_get_image_width(buffer);
  frame.height = arv_buffer_get_image_height(buffer);
  int bottom = 0;
  arv_buffer_get_image_padding(buffer, &frame.row_padding, &bottom);
  frame.bytes = {data, std::min(size, payload_bytes_)};
  return frame;
}

}  // namespace strobe::genicam
