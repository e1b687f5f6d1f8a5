// Any text is a scene or one line that says why not and where, whatever it inherits from; a scene's ball can
// be thrown or, far from its mean, is refused in words.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "sim/loading/load_scene.hpp"
#include "sim/motion/ball_path.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

using namespace strobe;
using namespace strobe::sim;

struct Parent {
  std::string_view name;
  std::string_view text;
};

/// Scenes that a text may inherit from: of each law, by springs, faulty ones, a loop, a long chain's end.
constexpr std::array<Parent, 7> kParents{{
    {"ode",
     "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 5\n[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
     "stiffness_ratio = 1.2\noffset_share = 0.1\n[[fault]]\nkind = \"ball_misses\"\n"},
    {"grip",
     "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 5\n[bounce]\ncontact = \"grip\"\ne = 0.8\n"
     "mu = 0.6\nex = 0.1\noffset_mm = 2.5\ndwell_ms = 5\n[ball]\nalpha = 0.5\n"},
    {"springs",
     "inherits = \"ode\"\n[ball]\ninertia = \"solid\"\nstiffness_npm = 20000\ndamping_nspm = 2\n"
     "[surface]\nfriction = 0.7\ntilt_deg = 2\n"},
    {"wrong", "inherits = \"ode\"\n[lamps]\ndealy_us = 3\n"},
    {"broken", "[machine\n"},
    {"loop", "inherits = \"fuzz\"\n"},
    {"child", "inherits = \"springs\"\n[surface]\ncourt_pace = 37\n"},
}};

bool begins_with_a_file(const std::string& what) {
  if (what.starts_with("fuzz.toml")) return true;
  return std::ranges::any_of(
      kParents, [&](const Parent& p) { return what.starts_with(std::string(p.name) + ".toml"); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = text_of(data, size);
  const auto resolve = [&](const std::string& name, const std::string&) -> Result<SceneText> {
    if (name == "fuzz") return SceneText{std::string(text), "fuzz.toml"};
    for (const Parent& parent : kParents)
      if (parent.name == name) return SceneText{std::string(parent.text), name + ".toml"};
    return fail("no scene of that name");
  };
  const auto scene = parse_scene(text, "fuzz.toml", resolve);
  if (!scene) {
    const std::string& what = scene.error().message;
    if (!begins_with_a_file(what) || what.find('\n') != std::string::npos) std::abort();
    return 0;
  }
  for (int shot = 1; shot <= 3; ++shot) {
    const auto path = BallPath::make(*scene, draw_shot_conditions(*scene, 1, shot));
    if (path ? !std::isfinite(path->rebound().lift_off.vx_mps) : path.error().message.empty()) std::abort();
  }
  return 0;
}
