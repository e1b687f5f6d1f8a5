// strobe-raw: a camera's RAW file as a TIFF file that the project reads (common/image/image_files.hpp): of a
// colour sensor as a mosaic, else grey. Exit status: 0 written; 1 the file is not one that is read; 2 bad
// usage.
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <fstream>
#include <string_view>

#include "common/image/image_files.hpp"
#include "host/drivers/raw/limits.hpp"
#include "host/drivers/raw/raw_file.hpp"

namespace {

constexpr const char* kUsage =
    "usage: strobe-raw FILE OUT.tif\n"
    "Writes the sensor's numbers of a camera's RAW file as TIFF, not demosaiced, for strobe, which starts "
    "it.\n";

int report(std::string_view message, int status) {
  fmt::print(stderr, "strobe-raw: {}\n", message);
  return status;
}

strobe::Result<void> convert(const char* from, const char* to) {
  auto raster = strobe::raw::read_raw_file(from);
  if (!raster) return tl::unexpected(raster.error());
  const auto bytes = strobe::image::encode_tiff(raster->pixels(), {.mosaic = raster->mosaic});
  if (!bytes) return tl::unexpected(bytes.error());
  std::ofstream file(to, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
  file.close();
  if (!file) return strobe::fail(fmt::format("{}: cannot be written", to));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--help") return std::fputs(kUsage, stdout) < 0 ? 1 : 0;
  if (argc != 3) return report("usage: strobe-raw FILE OUT.tif", 2);
  if (!strobe::raw::limit_this_process()) return report("cannot limit itself", 1);
  try {
    if (auto done = convert(argv[1], argv[2]); !done) return report(done.error().message, 1);
  } catch (const std::exception&) {  // bad_alloc
    return report("decoding takes too much memory", 1);
  } catch (...) {  // LibRaw's own
    return report("the file is damaged", 1);
  }
  return 0;
}
