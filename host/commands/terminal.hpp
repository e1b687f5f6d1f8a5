// Paints lines on the terminal with ncurses. One object at a time, one thread's.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/config/rig_file.hpp"
#include "host/loop/host_loop.hpp"
#include "host/view/render.hpp"

namespace strobe::host {

class Screen {
 public:
  /// Whether standard output is a terminal that ncurses can paint on.
  static bool possible();

  /// Takes the terminal over until destroyed. Install signal handlers before: ncurses then leaves them alone.
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  std::size_t width() const;
  /// Returns the key that was pressed since, or a negative number.
  int paint(const std::vector<std::string>& lines);
};

// What the commands share at the edge: signals, and where output goes. Single-threaded.

/// Random, positive.
std::int64_t random_host_id();

/// From now on SIGINT, SIGTERM, SIGHUP and SIGQUIT only count in ends_asked_for().
void catch_signals();
/// How urgently a person, or the system, has asked for the end: once for each SIGINT, SIGTERM and SIGHUP,
/// twice for SIGQUIT.
int ends_asked_for();
inline bool interrupted() { return ends_asked_for() > 0; }

/// Shows a session to a person or a script: one JSON object a line, lines of text, or the whole screen.
class Terminal final : public HostListener {
 public:
  enum class Style { json, plain, screen };
  /// The style that the options --json and --plain name.
  static Style style(bool json, bool plain);

  /// max_shots: results beyond are not printed; 0: no limit.
  explicit Terminal(Style style, std::string title = "", int max_shots = 0);

  /// From now on only results of these hosts' shots are shown: others', or those of a log that is played
  /// back, are none of the series.
  void show_only(std::function<bool(std::int64_t host_id)> shown) { shown_ = std::move(shown); }
  /// Takes the screen, if that is the style; where there is none that can be painted on, lines are printed.
  void open();
  bool owns_screen() const { return screen_ != nullptr; }
  ViewModel& model() { return model_; }

  /// Standard output in json and plain style, flushed; on a screen the model shows it.
  void on_shot_result(const Shot& result) override;
  /// Standard error; on a screen the model shows it.
  void on_notification(const std::string& text) override;
  /// For a person who sees no screen.
  void note(const std::string& text);
  /// Brings the model up to date and paints the screen, at most ten times a second.
  void show(HostLoop& loop);
  /// Why standard output did not take all that was printed on it; nothing: it did.
  const std::optional<std::string>& output_problem() const { return output_problem_; }
  /// Gives the screen back.
  void close() { screen_.reset(); }

 private:
  Style style_;
  int max_shots_;
  std::function<bool(std::int64_t)> shown_;
  ViewModel model_;
  std::unique_ptr<Screen> screen_;
  HostTime painted_;
  std::optional<std::string> output_problem_;
};

/// Lines on standard output.
void print(const std::vector<std::string>& lines);

/// --lcm-url, else the rig file's, else the default.
std::string lcm_url(const std::string& given, const RigFile& rig);

inline constexpr std::size_t kPlainWidth = 120;

/// Of --all. On a screen the key a does the same.
inline constexpr const char* kAllHelp =
    "experts' numbers as well: slip, what each uncertainty is made of, the flashes' code, the timing (key a "
    "on a screen)";

}  // namespace strobe::host
