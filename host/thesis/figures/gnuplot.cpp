#include "host/thesis/figures/gnuplot.hpp"

#include <string>
#include <system_error>

#include "common/config/files.hpp"
#include "host/external/program.hpp"

namespace strobe::report {

namespace fs = std::filesystem;

namespace {

std::string read(const fs::path& path) { return config::read_file(path.string()).value_or(""); }

/// Both formats say where they end.
bool whole(const fs::path& path) {
  const std::string content = read(path);
  const std::string tail = content.size() < 16 ? content : content.substr(content.size() - 16);
  return tail.find(path.extension() == ".svg" ? "</svg>" : "IEND") != std::string::npos;
}

}  // namespace

Result<fs::path> find_gnuplot() {
  if (const auto found = external::find_program("gnuplot")) return *found;
  return fail("figures need gnuplot, which is not installed: apt-get install gnuplot-nox");
}

Result<void> draw(const Figure& figure, const fs::path& folder, const fs::path& gnuplot) {
  const auto work = external::WorkFolder::make(folder);
  if (!work) return tl::unexpected(work.error());
  const std::string stem = file_stem(figure);
  const fs::path& in = work->path();
  if (const auto done = config::write_file(in / (stem + ".csv"), csv_text(figure)); !done) return done;
  if (const auto done = config::write_file(in / (stem + ".gp"), script_text(figure)); !done) return done;
  if (const auto done = external::run_program({gnuplot.string(), stem + ".gp"}, *work); !done)
    return fail("gnuplot did not draw " + stem + ".gp: " + done.error().message);
  for (const char* kind : {".svg", ".png"})
    if (!whole(in / (stem + kind)))
      return fail("gnuplot did not finish " + stem + kind + ": " + work->last_message());
  for (const char* kind : {".csv", ".gp", ".svg", ".png"}) {
    std::error_code error;
    fs::rename(in / (stem + kind), folder / (stem + kind), error);
    if (error) return fail((folder / (stem + kind)).string() + ": cannot be written: " + error.message());
  }
  return {};
}

}  // namespace strobe::report
