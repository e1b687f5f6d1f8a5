#include "host/external/raw_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "common/units/time.hpp"
#include "host/external/program.hpp"

namespace strobe::external {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "strobe-raw";
constexpr Duration kLongest = std::chrono::minutes(1);
constexpr std::array<std::string_view, 22> kEndings{
    ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".dng", ".erf", ".iiq", ".kdc", ".mef",
    ".mos", ".mrw", ".nef", ".nrw", ".orf", ".pef", ".raf", ".rw2", ".rwl", ".srw", ".x3f"};

/// The program's own words, without its name.
std::string complaint_of(const WorkFolder& folder, const std::string& otherwise) {
  const std::string line = folder.last_message(), name = std::string(kProgram) + ": ";
  return line.starts_with(name) ? line.substr(name.size()) : otherwise;
}

}  // namespace

bool is_raw_name(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(kEndings, ending) != kEndings.end();
}

Result<std::vector<unsigned char>> mosaic_of_raw_file(const fs::path& file) {
  const auto program = find_own_program(kProgram);
  if (!program)
    return fail(
        "it is a camera's RAW file, which strobe-raw reads: install the Debian package strobe-camera");
  std::error_code error;
  const fs::path temporary = fs::temp_directory_path(error);
  if (error) return fail("no folder for temporary files: " + error.message());
  const auto work = WorkFolder::make(temporary);
  if (!work) return tl::unexpected(work.error());
  const fs::path mosaic = work->path() / "mosaic.tif";
  if (auto done = run_program({*program, fs::absolute(file), mosaic}, *work, {}, kLongest); !done)
    return fail(complaint_of(*work, done.error().message));
  std::ifstream stream(mosaic, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream.tellg();
  if (size <= 0) return fail("strobe-raw wrote nothing");
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(bytes.data()), size);
  if (stream.gcount() != size) return fail((mosaic.string() + ": cannot be read"));
  return bytes;
}

}  // namespace strobe::external
