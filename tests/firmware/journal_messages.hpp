// Messages as a publisher puts them into its journal.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/publisher/journal.hpp"

namespace strobe::journal_test {

inline constexpr std::int64_t kBoot = 0x1122334455667788;

template <typename T>
std::vector<std::uint8_t> encoded(const T& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

inline firmware::Message event(std::int64_t sequence, std::int32_t shot_id = 0,
                               std::int64_t boot_id = kBoot) {
  firmware::Event content;
  content.kind = firmware::EventKind::flash;
  content.shot_id = shot_id;
  content.detail = "words";
  return {firmware::Message::Kind::event,
          {sequence, sequence},
          "STROBE/bench/EVENT",
          encoded(to_message(content, boot_id, sequence))};
}

inline firmware::Message shot(std::int32_t shot_id, SequenceRange sequences) {
  firmware::ShotRecord record;
  record.shot_id = shot_id;
  record.flashes.resize(3);
  return {firmware::Message::Kind::shot, sequences, "STROBE/bench/SHOT",
          encoded(to_message(record, firmware::Rig(), kBoot, sequences, {{"operator", "M"}}))};
}

}  // namespace strobe::journal_test
