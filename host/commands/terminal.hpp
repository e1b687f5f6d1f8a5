// What the commands share at the edge: clocks, signals, where output goes. One thread's.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/session/session.hpp"
#include "host/view/render.hpp"
#include "host/view/screen.hpp"

namespace strobe::host {

std::int64_t steady_now_ns();
std::int64_t wall_now_us();
/// All three clocks, read one after the other.
ClockReading read_clocks();
/// Random, positive.
std::int64_t random_host_id();

/// From now on SIGINT, SIGTERM and SIGHUP only set a mark.
void catch_signals();
bool interrupted();

/// How to tell a person or a script: one JSON object a line, lines of text, or the whole screen.
class Terminal {
 public:
  enum class Style { json, plain, screen };

  /// The screen only where there is one.
  explicit Terminal(Style style);

  Style style() const { return style_; }
  bool owns_screen() const { return screen_ != nullptr; }
  /// Standard output in json and plain style, flushed; nothing on a screen (the model shows it).
  void shot_result(const ShotResult& shot_result);
  /// Standard error; nothing on a screen.
  void notify(const std::string& text);
  /// The screen, at most ten times a second.
  void show(const Model& model, std::int64_t now_ns);
  /// Gives the screen back.
  void close() { screen_.reset(); }

 private:
  Style style_;
  std::unique_ptr<Screen> screen_;
  std::int64_t painted_ns_ = 0;
};

/// Lines on standard output.
void print(const std::vector<std::string>& lines);

/// The one JSON line of an shot_result: the readout, or the train report of a dry shot.
std::string shot_result_json(const ShotResult& shot_result);

/// --lcm-url, else the rig file's, else the default.
std::string lcm_url(const std::string& given, const RigFile& rig);

inline constexpr std::size_t kPlainWidth = 120;

}  // namespace strobe::host
