// What a batch does with every session. Plain values; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/digitize.hpp"

namespace strobe::host {

struct BatchSettings {
  std::string version;                             ///< of strobe: another one computes anew
  std::string rig;                                 ///< path; empty: the rig file that each session keeps
  std::string calibration_text, calibration_name;  ///< name empty: the rig file's own
  digitize::Effort effort = digitize::Effort::standard;
  bool stored_frames = false;  ///< reduce what was digitized, measure no photograph
};

/// Of sixteen hexadecimal digits: other settings, another batch.
std::string batch_id(const BatchSettings& settings, const std::string& rig_text);

/// The rig with the batch's calibration. Fails as read_rig does.
Result<RigFile> calibrated(RigFile rig, const BatchSettings& settings);

/// BLAKE2b of 128 bits, hexadecimal: of bytes that differ another.
class ContentHash {
 public:
  ContentHash();
  /// Each part with its size, so that no two lists of parts are alike.
  ContentHash& add(std::string_view part);
  std::string digits() const;

 private:
  std::string parts_;
};

/// Of a file's bytes, read in pieces. Fails with the file's name.
Result<std::string> hash_of_file(const std::string& path);

}  // namespace strobe::host
