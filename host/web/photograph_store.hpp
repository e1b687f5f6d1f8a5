// Photographs of sessions as pictures for a browser. Reads files; thread-safe, one at a time; keeps the
// pictures asked for last (48 MB) and the size of those decoded last.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "host/web/bounded_cache.hpp"
#include "host/web/http/message.hpp"
#include "host/web/session_folders.hpp"

namespace strobe::web {

struct PictureSize {
  int width_px = 0, height_px = 0;
};

struct Picture {
  std::shared_ptr<const std::string> jpeg;
  std::string tag;  ///< names this content
};

class PhotographStore {
 public:
  /// file: a photograph that the session keeps; one that is no file of the folder's own, or that cannot be
  /// decoded, is refused with 404.
  Answered<PictureSize> size(const std::filesystem::path& session, const std::filesystem::path& file);
  /// width_px: at least so wide, if the photograph is; 0 or less: as wide as it is. Stretched as
  /// display_grey() does.
  Answered<Picture> picture(const std::filesystem::path& session, const std::filesystem::path& file,
                            int width_px);

  /// Widths that are made, so that few pictures are kept of each photograph; else the photograph's own.
  static constexpr int kWidths_px[] = {320, 640, 960, 1280, 1920, 2560};
  static constexpr std::size_t kMaxKept_bytes = std::size_t{48} << 20;

 private:
  struct Key {
    std::filesystem::path file;
    FileStamp stamp;
    int width_px = 0;
    auto operator<=>(const Key&) const = default;
  };
  Answered<Picture> make(Key key);

  std::mutex mutex_;
  BoundedCache<Key, Picture> pictures_{kMaxKept_bytes};
  BoundedCache<Key, PictureSize> sizes_{256};
};

}  // namespace strobe::web
