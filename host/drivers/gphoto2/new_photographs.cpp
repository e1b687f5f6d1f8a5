#include "host/drivers/gphoto2/new_photographs.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "host/drivers/gphoto2/photograph_names.hpp"

namespace strobe::gphoto2 {

namespace {

namespace fs = std::filesystem;
using tether::Event;

constexpr Duration kRawFollows = std::chrono::seconds{2};  // its JPEG, at the latest
constexpr Duration kSizeHolds = milliseconds{400};
constexpr int kMaxTries = 3;

CardFile by_stem(const CardFile& file) { return {file.folder, stem_of(file.name)}; }

}  // namespace

Result<std::size_t> NewPhotographs::begin(GphotoCamera& camera) {
  const auto last = camera.last_folder();
  if (!last) return tl::unexpected(last.error());
  first_folder_ = *last;
  const auto files = camera.files(first_folder_);
  if (!files) return tl::unexpected(files.error());
  known_.insert(files->begin(), files->end());
  return files->size();
}

void NewPhotographs::on_added(const CardFile& file, HostTime now) {
  if (known_.insert(file).second) waiting_.push_back({file, now});
}

Result<void> NewPhotographs::look(GphotoCamera& camera, HostTime now, bool by_size) {
  const auto files = camera.files(first_folder_);
  if (!files) return tl::unexpected(files.error());
  for (const CardFile& file : *files) {
    if (!known_.insert(file).second) continue;
    waiting_.push_back({file, now});
    waiting_.back().growing = by_size;
  }
  return {};
}

bool NewPhotographs::whole(GphotoCamera& camera, Waiting& waiting, HostTime now) {
  if (waiting.growing) {
    const auto size = camera.size(waiting.file);
    if (size != std::exchange(waiting.size, size)) {
      waiting.since = now;
      return false;
    }
    if (now - waiting.since < kSizeHolds) return false;
  }
  if (file_kind(waiting.file.name) != FileKind::jpeg || (written_ && !written_->raw)) return true;
  return raw_.contains(by_stem(waiting.file)) || now - waiting.since >= kRawFollows;
}

Event NewPhotographs::stored(const CardFile& file, const std::string& name) {
  return tether::PhotographEvent{name, file_number(file.name), std::nullopt, 0};
}

std::vector<Event> NewPhotographs::remove_from_camera(GphotoCamera& camera, const CardFile& file) {
  if (!delete_from_camera_) return {};
  const auto removed = camera.remove(file);
  if (removed) return {};
  return {tether::NoteEvent{"it stays on the camera: " + removed.error().message}};
}

Result<std::vector<Event>> NewPhotographs::take_one(GphotoCamera& camera, Waiting& waiting) {
  const CardFile& file = waiting.file;
  const FileKind kind = file_kind(file.name);
  if (kind == FileKind::other)
    return std::vector<Event>{tether::NoteEvent{file.name + " is no photograph: left on the camera"}};
  if (kind == FileKind::jpeg && raw_.contains(by_stem(file))) return remove_from_camera(camera, file);
  const std::string name = free_name(folder_, safe_name(file.name));
  const fs::path part = folder_ / (name + ".part");
  auto saved = camera.save(file, part, delete_from_camera_);
  const auto size = saved ? camera.size(file) : std::nullopt;
  std::error_code error;
  if (size && fs::file_size(part, error) != *size)
    saved = fail(fmt::format("{}: {} of {} bytes came", file.name, fs::file_size(part, error), *size));
  if (saved) fs::rename(part, folder_ / name, error);
  if (saved && error) saved = fail((folder_ / name).string() + ": " + error.message());
  if (!saved) {
    fs::remove(part, error);
    if (!camera.answers()) return tl::unexpected(saved.error());
    if (++waiting.tries < kMaxTries) return std::vector<Event>{};
    return std::vector<Event>{tether::LostEvent{file_number(file.name), std::nullopt, saved.error().message}};
  }
  if (kind != FileKind::jpeg) raw_.insert(by_stem(file));
  std::vector<Event> events{stored(file, name)};
  for (Event& event : remove_from_camera(camera, file)) events.push_back(std::move(event));
  return events;
}

Result<std::vector<Event>> NewPhotographs::take(GphotoCamera& camera, HostTime now) {
  std::vector<Event> all;
  for (std::size_t i = 0; i < waiting_.size();) {
    if (!whole(camera, waiting_[i], now)) {
      ++i;
      continue;
    }
    auto events = take_one(camera, waiting_[i]);
    if (!events) {
      // What came before it is told all the same.
      if (all.empty()) return events;
      return all;
    }
    const bool again = events->empty() && waiting_[i].tries > 0 && waiting_[i].tries < kMaxTries;
    if (again) {
      ++i;
    } else {
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    for (Event& event : *events) all.push_back(std::move(event));
  }
  return all;
}

}  // namespace strobe::gphoto2
