#include "host/web/photograph_store.hpp"

#include <fmt/format.h>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/overlay.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNotOwn = "the photograph is no file of the session";
constexpr int kPictureQuality = 85;  // of JPEG

int made_width(int wanted_px) {
  for (const int width : PhotographStore::kWidths_px)
    if (wanted_px > 0 && wanted_px <= width) return width;
  return 0;
}

Answered<digitize::Photograph> decoded_photograph(const fs::path& file) {
  auto photograph = digitize::load_photograph(file);
  if (!photograph) return unanswered(404, photograph.error().message);
  return std::move(*photograph);
}

Result<std::vector<std::uint8_t>> encoded_picture(const digitize::Photograph& photograph, int width_px) {
  cv::Mat intensity = photograph.intensity;
  if (width_px > 0 && width_px < photograph.width()) {
    const int height_px =
        std::max(1, cvRound(static_cast<double>(photograph.height()) * width_px / photograph.width()));
    cv::resize(intensity, intensity, cv::Size(width_px, height_px), 0.0, 0.0, cv::INTER_AREA);
  }
  return image::encode_jpeg(image::pixels_of(digitize::display_grey(intensity)), kPictureQuality);
}

}  // namespace

Answered<PictureSize> PhotographStore::size(const fs::path& session, const fs::path& file) {
  if (!is_own_file(session, file)) return unanswered(404, kNotOwn);
  const Key key{file, stamp_of(file), 0};
  {
    const std::lock_guard lock(mutex_);
    if (const PictureSize* known = sizes_.find(key)) return *known;
  }
  // Whoever asks for the size asks for the picture next.
  if (const auto made = picture(session, file, 1280); !made) return tl::unexpected(made.error());
  const std::lock_guard lock(mutex_);
  const PictureSize* known = sizes_.find(key);
  return known != nullptr ? Answered<PictureSize>(*known) : unanswered(404, "the photograph changes");
}

Answered<Picture> PhotographStore::picture(const fs::path& session, const fs::path& file, int width_px) {
  if (!is_own_file(session, file)) return unanswered(404, kNotOwn);
  const std::lock_guard lock(mutex_);
  Key key{file, stamp_of(file), made_width(width_px)};
  if (const PictureSize* size = sizes_.find({file, key.stamp, 0});
      size != nullptr && key.width_px >= size->width_px)
    key.width_px = 0;
  if (const Picture* known = pictures_.find(key)) return *known;
  return make(std::move(key));
}

Answered<Picture> PhotographStore::make(Key key) {
  const auto photograph = decoded_photograph(key.file);
  if (!photograph) return tl::unexpected(photograph.error());
  sizes_.put({key.file, key.stamp, 0}, {photograph->width(), photograph->height()}, 1);
  if (key.width_px >= photograph->width()) key.width_px = 0;
  const auto jpeg = encoded_picture(*photograph, key.width_px);
  if (!jpeg) return unanswered(500, jpeg.error().message);
  Picture picture;
  picture.jpeg = std::make_shared<const std::string>(jpeg->begin(), jpeg->end());
  picture.tag = fmt::format("{:x}-{:x}-{:x}-{}", std::hash<std::string>{}(key.file.string()), key.stamp.bytes,
                            key.stamp.changed, key.width_px);
  const std::size_t bytes = picture.jpeg->size();
  return pictures_.put(std::move(key), std::move(picture), bytes);
}

}  // namespace strobe::web
