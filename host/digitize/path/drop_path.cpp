#include "host/digitize/path/drop_path.hpp"

#include <algorithm>
#include <utility>

#include "host/digitize/path/straight_drop.hpp"

namespace strobe::digitize {
namespace {

void take_flight(const StraightDrop::Flight& flight, const std::vector<int>& images, Path& path) {
  std::vector<int>& leg = path.legs.emplace_back();
  for (std::size_t k = 0; k < flight.image.size(); ++k) {
    leg.push_back(images[static_cast<std::size_t>(flight.image[k])]);
    path.flash[static_cast<std::size_t>(leg.back())] = flight.flash[k];
  }
}

}  // namespace

void take_drop_images(std::span<const PathPoint> points, std::vector<int> images, const PathContext& context,
                      Path& path) {
  std::vector<DropImage> heights;
  for (const int i : images) {
    const PathPoint& p = points[static_cast<std::size_t>(i)];
    heights.push_back({p.at.y, p.sd_px});
  }
  path.straight = true;
  path.ambiguous.clear();
  const auto drop = split_drop(heights, {context.diameter_px, context.gravity_pxps2, context.flash_times_s});
  if (!drop) {
    path.legs = {std::move(images)};
    return;
  }
  path.legs.clear();
  path.flash.assign(points.size(), -1);
  take_flight(drop->down, images, path);
  take_flight(drop->up, images, path);
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (path.flash[static_cast<std::size_t>(images[k])] >= 0) continue;
    const bool doubled = std::ranges::find(drop->doubled, static_cast<int>(k)) != drop->doubled.end();
    path.outliers.push_back({images[k], false, doubled, drop->off_px[k]});
  }
}

}  // namespace strobe::digitize
