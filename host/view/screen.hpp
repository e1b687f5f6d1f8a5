// Paints lines on the terminal with ncurses. One object at a time, one thread's.
#pragma once

#include <string>
#include <vector>

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

}  // namespace strobe::host
