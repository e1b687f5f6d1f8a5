// Folders of strobe photographs with the truth about them: truth.json, as tests/real/README.md documents it.
// Image coordinates: px, x to the right, y downwards from the top left pixel's centre.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::real {

struct Point {
  double x = 0.0, y = 0.0;
};

enum class Kind {
  ball,      ///< must be found
  optional,  ///< partly hidden, saturated, cut by the border, out of the size's tolerance: counts neither way
  ghost,     ///< of ambient light between the flashes: must be left alone
};

struct Circle {
  double x = 0.0, y = 0.0;
  double d = 0.0;  ///< diameter, above 0
};

struct Ball : Circle {
  Kind kind = Kind::ball;
};

struct Photograph {
  std::string file;            ///< within its folder
  std::filesystem::path path;  ///< to open
  double ball_diameter_m = 0.0;
  double px_per_m = 0.0;          ///< the scale that a program is told
  std::vector<Ball> balls;        ///< by the first annotator
  std::vector<Point> ghost_path;  ///< empty, or two corners and more; whatever lies along it is a ghost
  bool curved = false;            ///< the path is more than one straight leg or two
  bool bounces = false;           ///< it tells up from down
  std::optional<std::vector<Ball>> second;  ///< by another annotator, or on another day
};

/// Fails with one line that names the file, the photograph and the field. Pure; any bytes; thread-safe.
Result<std::vector<Photograph>> parse_collection(std::string_view text, const std::string& name);

/// Of folder/truth.json. Fails likewise, and where a photograph that it names is not there. Reads files.
Result<std::vector<Photograph>> load_collection(const std::filesystem::path& folder);

}  // namespace strobe::real
