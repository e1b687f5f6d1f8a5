// The photographs that a camera makes from now on: noticed by its events or by looking at its card, taken
// over once each, whole and under a new name. Files that were on the card before are left alone. Of a RAW
// file with a JPEG beside it the RAW is taken. Reads and removes files of the camera, writes files; one
// thread.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/units/time.hpp"
#include "host/drivers/gphoto2/gphoto_camera.hpp"
#include "host/drivers/gphoto2/problems.hpp"

namespace strobe::gphoto2 {

class NewPhotographs {
 public:
  /// delete_from_camera: once they are on this machine's disk.
  NewPhotographs(std::filesystem::path folder, bool delete_from_camera)
      : folder_(std::move(folder)), delete_from_camera_(delete_from_camera) {}

  /// Remembers what is on the card. Returns how many files those are.
  Result<std::size_t> begin(GphotoCamera& camera);
  void on_added(const CardFile& file, HostTime now);
  /// For what was made while nobody listened. by_size: a file may still be growing.
  Result<void> look(GphotoCamera& camera, HostTime now, bool by_size);
  void set_written(std::optional<WrittenFiles> written) { written_ = written; }

  /// Takes over what is whole: PhotographEvent, LostEvent, NoteEvent. Fails if the camera is gone meanwhile;
  /// what it was about then is taken over later.
  Result<std::vector<tether::Event>> take(GphotoCamera& camera, HostTime now);
  bool waits() const { return !waiting_.empty(); }

 private:
  struct Waiting {
    CardFile file;
    HostTime since;
    bool growing = false;  ///< whole once its size stays the same
    std::optional<std::uint64_t> size{};
    int tries = 0;
  };
  bool whole(GphotoCamera& camera, Waiting& waiting, HostTime now);
  /// Empty: it is to be tried again.
  Result<std::vector<tether::Event>> take_one(GphotoCamera& camera, Waiting& waiting);
  tether::Event stored(const CardFile& file, const std::string& name);
  std::vector<tether::Event> remove_from_camera(GphotoCamera& camera, const CardFile& file);

  std::filesystem::path folder_;
  bool delete_from_camera_;
  std::string first_folder_;  ///< of the card, in which new files may be
  std::set<CardFile> known_;
  std::set<CardFile> raw_;  ///< taken over, by stem
  std::vector<Waiting> waiting_;
  std::optional<WrittenFiles> written_;
};

}  // namespace strobe::gphoto2
