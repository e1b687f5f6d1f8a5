#include "host/view/screen.hpp"

#include <ncurses.h>
#include <unistd.h>

#include <clocale>
#include <cstdlib>

namespace strobe::host {

bool Screen::possible() {
  const char* terminal = std::getenv("TERM");
  return ::isatty(STDOUT_FILENO) == 1 && terminal && *terminal && std::string(terminal) != "dumb";
}

Screen::Screen() {
  std::setlocale(LC_CTYPE, "");
  std::setlocale(LC_NUMERIC, "C");
  initscr();
  curs_set(0);
  leaveok(stdscr, TRUE);
}

Screen::~Screen() { endwin(); }

std::size_t Screen::width() const {
  return static_cast<std::size_t>(getmaxx(stdscr) > 0 ? getmaxx(stdscr) : 80);
}

int Screen::paint(const std::vector<std::string>& lines) {
  timeout(0);
  const int key = getch();  // takes note of a resized terminal, too
  erase();
  const int height = getmaxy(stdscr);
  for (int row = 0; row < height && row < static_cast<int>(lines.size()); ++row) {
    mvaddstr(row, 0, lines[static_cast<std::size_t>(row)].c_str());
  }
  refresh();
  return key;
}

}  // namespace strobe::host
