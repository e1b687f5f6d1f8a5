// Any text is a scene or one line that says why not; a scene's ball can be thrown.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "sim/rig/ball_path.hpp"
#include "sim/rig/scene.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto scene = strobe::sim::parse_scene(text, "fuzz.toml");
  if (!scene) {
    const std::string& what = scene.error().message;
    if (what.empty() || !what.starts_with("fuzz.toml") || what.find('\n') != std::string::npos) std::abort();
    return 0;
  }
  for (int shot = 1; shot <= 3; ++shot) {
    if (!strobe::sim::BallPath::make(*scene, strobe::sim::draw_throw(*scene, 1, shot))) std::abort();
  }
  return 0;
}
