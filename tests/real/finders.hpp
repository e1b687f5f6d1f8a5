// Whoever finds balls on a photograph: `strobe digitize`, any other program, and two detectors of OpenCV as
// what anybody would try first.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "tests/real/judge.hpp"

namespace strobe::real {

struct Question {
  std::filesystem::path file;  ///< absolute
  cv::Mat pixels;              ///< the same: CV_8U or CV_16U of 1 or 3 channels, red first
  double ball_diameter_m = 0.0;
  double px_per_m = 0.0;           ///< as it is told
  double tolerance_percent = 0.0;  ///< of the size that this tells
  double told_px() const { return px_per_m * ball_diameter_m; }
};

/// Where a program looked and why it took nothing.
struct Refusal {
  Point at;
  std::string why;
};

struct Answer {
  std::vector<Found> circles;
  std::vector<Refusal> refusals;
};

/// Thread-safe. Fails with one line.
using Finder = std::function<Result<Answer>(const Question&)>;

/// A shell's command in which {file}, {ball_diameter_m}, {px_per_m} and {size_tolerance} (%) are replaced. It
/// prints what parse_answer() takes, exits with 0, or 1 if it likes, and has five minutes.
Finder finder_of(const std::string& command);

/// "strobe digitize" of that program, as such a command.
std::string digitize_command(const std::filesystem::path& strobe);

/// {"circles": [{"x", "y", "d"}]}, px, y downwards, with "x_sd", "y_sd" and "d_sd" or without, or a list of
/// such; or a frame as `strobe digitize --json` prints it, of which `unmeasured` says why places were
/// refused. height: the photograph's, px. told_px: the diameter of what has none. The text, or else its first
/// line, is JSON. Pure; thread-safe.
Result<Answer> parse_answer(std::string_view text, int height, double told_px);

struct NamedFinder {
  std::string name;
  Finder find;
};

/// cv::HoughCircles, each method at settings that people use.
std::vector<NamedFinder> hough_finders();

/// cv::SimpleBlobDetector of bright discs of the size that is told, likewise.
std::vector<NamedFinder> blob_finders();

}  // namespace strobe::real
