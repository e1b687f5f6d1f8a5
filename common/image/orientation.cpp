#include "common/image/orientation.hpp"

#include <cstring>

namespace strobe::image {

Raster turned(const Raster& stored, int orientation) {
  const bool exchanged = orientation >= 5;  // stored rows are columns
  // Whether the first row is at the bottom (right, if exchanged), the first column at the right (bottom).
  const bool last_row_first = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const bool last_column_first = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  Raster shown(exchanged ? stored.height() : stored.width(), exchanged ? stored.width() : stored.height(),
               stored.channels(), stored.bits());
  const std::size_t size = stored.pixel_bytes();
  for (int row = 0; row < stored.height(); ++row) {
    const int down = last_row_first ? stored.height() - 1 - row : row;
    const std::uint8_t* from = stored.row(row);
    for (int column = 0; column < stored.width(); ++column, from += size) {
      const int across = last_column_first ? stored.width() - 1 - column : column;
      std::memcpy(exchanged ? shown.row(across) + size * static_cast<std::size_t>(down)
                            : shown.row(down) + size * static_cast<std::size_t>(across),
                  from, size);
    }
  }
  return shown;
}

}  // namespace strobe::image
