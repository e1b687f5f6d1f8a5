#include "host/batch/batch_settings.hpp"

#include <fmt/format.h>
#include <sodium.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

namespace strobe::host {
namespace {

constexpr std::size_t kHash_bytes = 16;

std::string hexadecimal(const std::array<unsigned char, kHash_bytes>& hash) {
  std::string text;
  for (const unsigned char byte : hash) text += fmt::format("{:02x}", byte);
  return text;
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

ContentHash::ContentHash() = default;

ContentHash& ContentHash::add(std::string_view part) {
  parts_ += fmt::format("{}:", part.size());
  parts_ += part;
  return *this;
}

std::string ContentHash::digits() const {
  std::array<unsigned char, kHash_bytes> hash{};
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(parts_.data()),
                     parts_.size(), nullptr, 0);
  return hexadecimal(hash);
}

Result<std::string> hash_of_file(const std::string& path) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail(path + ": " + std::strerror(errno));
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, kHash_bytes);
  std::vector<unsigned char> piece(std::size_t{1} << 20);
  while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), file.get()))
    crypto_generichash_update(&state, piece.data(), size);
  if (std::ferror(file.get()) != 0) return fail(path + ": " + std::strerror(errno));
  std::array<unsigned char, kHash_bytes> hash{};
  crypto_generichash_final(&state, hash.data(), hash.size());
  return hexadecimal(hash);
}

std::string batch_id(const BatchSettings& settings, const std::string& rig_text) {
  return ContentHash()
      .add(settings.version)
      .add(rig_text)
      .add(settings.calibration_text)
      .add(std::to_string(static_cast<int>(settings.effort)))
      .add(settings.stored_frames ? "stored" : "again")
      .digits()
      .substr(0, 16);
}

Result<RigFile> calibrated(RigFile rig, const BatchSettings& settings) {
  if (settings.calibration_name.empty()) return rig;
  auto camera = with_calibration(rig.camera, settings.calibration_text, settings.calibration_name);
  if (!camera) return tl::unexpected(camera.error());
  rig.camera = std::move(*camera);
  rig.calibration_text = settings.calibration_text;
  return rig;
}

}  // namespace strobe::host
