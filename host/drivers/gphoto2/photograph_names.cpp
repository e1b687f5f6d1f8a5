#include "host/drivers/gphoto2/photograph_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <string_view>
#include <system_error>

#include "host/drivers/gphoto2/config_tree.hpp"

namespace strobe::gphoto2 {

namespace {

constexpr std::array<std::string_view, 20> kRaw{".nef", ".nrw", ".cr2", ".cr3", ".crw", ".arw", ".sr2",
                                                ".srf", ".dng", ".raf", ".orf", ".rw2", ".pef", ".srw",
                                                ".x3f", ".3fr", ".fff", ".iiq", ".rwl", ".raw"};
constexpr std::array<std::string_view, 3> kDeveloped{".tif", ".tiff", ".png"};
constexpr std::array<std::string_view, 2> kJpeg{".jpg", ".jpeg"};

bool is_digit(unsigned char c) { return std::isdigit(c) != 0; }

}  // namespace

FileKind file_kind(const std::string& name) {
  const std::string extension = lower_case(std::filesystem::path(name).extension().string());
  const auto in = [&extension](const auto& list) { return std::ranges::find(list, extension) != list.end(); };
  if (in(kRaw)) return FileKind::raw;
  if (in(kDeveloped)) return FileKind::developed;
  return in(kJpeg) ? FileKind::jpeg : FileKind::other;
}

std::string stem_of(const std::string& name) { return std::filesystem::path(name).stem().string(); }

std::int64_t file_number(const std::string& name) {
  const std::string stem = stem_of(name);
  const auto last = std::find_if(stem.rbegin(), stem.rend(), is_digit);
  const auto before = std::find_if_not(last, stem.rend(), is_digit);
  std::int64_t number = -1;
  const auto [end, error] = std::from_chars(&*stem.begin() + (before.base() - stem.begin()),
                                            &*stem.begin() + (last.base() - stem.begin()), number);
  return error == std::errc() ? number : -1;
}

std::string safe_name(const std::string& name) {
  std::string safe = name;
  for (char& c : safe) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_' || c == '-';
    if (!kept) c = '_';
  }
  if (safe.empty() || safe.front() == '.') safe.insert(0, "_");
  return safe;
}

std::string free_name(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path path(name);
  std::string free = name;
  std::error_code error;
  for (int copy = 2; std::filesystem::exists(folder / free, error); ++copy)
    free = fmt::format("{}-{}{}", path.stem().string(), copy, path.extension().string());
  return free;
}

}  // namespace strobe::gphoto2
