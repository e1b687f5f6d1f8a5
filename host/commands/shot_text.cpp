#include "host/commands/shot_text.hpp"

#include <algorithm>

#include "host/commands/terminal.hpp"
#include "host/view/render.hpp"

namespace strobe::host {

std::string ShotText::now() const { return utc_for_table(clock_.read().wall); }

void ShotText::add(const std::string& line) {
  std::string text = now() + "  " + line;
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' '; }, ' ');
  folder_.add_text(text + "\n");
}

void ShotText::on_shot_result(const Shot& result) {
  if (!shown_(result.host_id)) return;
  std::string text;
  for (const std::string& line : render_shot(result, kPlainWidth))
    text += (text.empty() ? now() + "  " : std::string(4, ' ')) + line + "\n";
  folder_.add_text(text);
}

}  // namespace strobe::host
