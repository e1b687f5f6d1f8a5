// Assigns the sensors' edges to flashes. A flash's window runs from a little before it was issued (commanded,
// if it never was) for half a period: its first edge of each sensor is the flash. Further edges there, and every
// edge in the rest of its period, are light that nobody asked for and are counted as extra: such light makes an
// image as well. Edges before the first flash and a period after the last are not the train's.
// Real-time safe; no allocation beyond the record's capacity.
#pragma once

#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

class FlashBook {
 public:
  /// A window begins this much before the flash was issued: covers what a configured sensor delay is wrong
  /// by.
  static constexpr Duration kEarly = microseconds(20);

  void open(ShotRecord& record, Duration period) noexcept;
  /// Enters a planned flash; in order of their instants.
  void plan(MonoTime commanded) noexcept;
  void issued(std::int32_t flash_index, MonoTime start, MonoTime end) noexcept;
  /// seen: the stamp with the sensor's delay subtracted.
  void edge(Input sensor, MonoTime seen) noexcept;

 private:
  FlashRecord* last_begun(MonoTime seen) noexcept;

  ShotRecord* record_ = nullptr;
  Duration period_;
};

}  // namespace strobe::firmware
