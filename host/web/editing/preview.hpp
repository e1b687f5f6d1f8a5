// What corrections would make of a shot, before they are saved. Reads files, writes none; keeps the automatic measurement
// of the shots looked at last, so that a change is seen at once. Thread-safe, one at a time.
#pragma once

#include <mutex>
#include <string>

#include "host/archive/redigitize.hpp"
#include "host/web/archive/answered.hpp"
#include "host/web/archive/bounded_cache.hpp"
#include "host/web/archive/session_folders.hpp"

namespace strobe::web {

struct Preview {
  host::Shot shot;               ///< with the corrected digitization as its newest, and the result of that
  digitize::Digitization found;  ///< likewise, as measured
  digitize::DigitizeSettings settings;
  int width_px = 0, height_px = 0;  ///< of the photograph
};

class Previewer {
 public:
  /// corrections: a text as of --edit; file_name: for messages. The numbers are those that saving it gives. Refused with 422
  /// and one line that names what is wrong with the corrections, with 409 where the photograph cannot be measured.
  Answered<Preview> preview(const host::StoredSession& session, const host::Shot& shot,
                            const std::string& corrections, const std::string& file_name);
  /// Without corrections: as it was found.
  Answered<Preview> automatic(const host::StoredSession& session, const host::Shot& shot);

  static constexpr std::size_t kMaxKept = 8;

 private:
  struct Key {
    std::filesystem::path photograph;
    FileStamp stamp;
    ShotKey shot;
    auto operator<=>(const Key&) const = default;
  };
  struct Measured {
    digitize::Digitization found;
    digitize::DigitizeSettings settings;
    int width_px = 0, height_px = 0;
  };
  Answered<Measured> measured(const host::StoredSession& session, const host::Shot& shot);

  std::mutex mutex_;
  BoundedCache<Key, Measured> kept_{kMaxKept};
};

}  // namespace strobe::web
