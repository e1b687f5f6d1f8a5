#include "host/drivers/raw/defects.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace strobe::raw {

namespace {

constexpr int kMinOfRange = 50;  // a fiftieth
constexpr std::array<std::array<int, 2>, 4> kPairs{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

}  // namespace

int mend_pixels(image::Raster& raster, int black, int white) {
  const int step = raster.mosaic ? 2 : 1;
  const int least = (white - black) / kMinOfRange;
  const auto number = [&](int x, int y) -> std::uint16_t& {
    return reinterpret_cast<std::uint16_t*>(raster.row(y))[x];
  };
  struct Mended {
    int x, y;
    std::uint16_t number;
  };
  std::vector<Mended> mended;  // all judged before one is changed
  for (int y = step; y < raster.height() - step; ++y) {
    for (int x = step; x < raster.width() - step; ++x) {
      const int own = number(x, y);
      int low = 65535, high = 0;
      for (const auto& [dx, dy] : kPairs) {
        const int one = number(x + step * dx, y + step * dy), other = number(x - step * dx, y - step * dy);
        low = std::min({low, one, other});
        high = std::max({high, one, other});
      }
      const int beyond = std::max(own - high, low - own);
      if (beyond <= least || beyond <= 2 * (high - low)) continue;
      int apart = 65536, mean = 0;
      for (const auto& [dx, dy] : kPairs) {
        const int one = number(x + step * dx, y + step * dy), other = number(x - step * dx, y - step * dy);
        if (std::abs(one - other) >= apart) continue;
        apart = std::abs(one - other);
        mean = (one + other) / 2;
      }
      mended.push_back({x, y, static_cast<std::uint16_t>(mean)});
    }
  }
  for (const Mended& pixel : mended) number(pixel.x, pixel.y) = pixel.number;
  return static_cast<int>(mended.size());
}

}  // namespace strobe::raw
