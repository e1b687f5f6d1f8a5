#include "host/report/content/overlay_picture.hpp"

#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "host/digitize/overlay.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::lab_report {

namespace {

constexpr int kJpegQuality = 78;

/// Without times: there is room for the images' numbers alone.
Result<reduction::Frame> frame_of(const host::Shot& shot) {
  auto frame = messages::frame_from_lcm(shot.digitizations.back().frame);
  if (!frame) return frame;
  for (auto& image : frame->images) image.time_s = std::numeric_limits<double>::quiet_NaN();
  return frame;
}

}  // namespace

Result<Picture> overlay_picture(const host::StoredSession& session, const host::Shot& shot,
                                int longest_side_px) {
  if (!shot.photograph) return fail("No photograph is kept.");
  const auto path = shot.photograph->is_absolute() ? *shot.photograph : session.folder / *shot.photograph;
  const auto photograph = digitize::load_photograph(path);
  if (!photograph) return fail("The photograph cannot be shown: " + photograph.error().message + ".");
  const auto settings = host::digitize_settings(session.rig, photograph->width(), photograph->height());
  if (!settings) return fail("The photograph cannot be shown: " + settings.error().message + ".");
  digitize::Digitization found;
  if (!shot.digitizations.empty()) {
    auto frame = frame_of(shot);
    if (!frame) return fail("The measurement cannot be shown: " + frame.error().message + ".");
    found.frame = *std::move(frame);
  }
  const cv::Mat drawn =
      digitize::draw_overlay(*photograph, settings->map, found, {.longest_side_px = longest_side_px});
  cv::Mat colours;
  cv::cvtColor(drawn, colours, cv::COLOR_BGR2RGB);
  auto jpeg = image::encode_jpeg(image::pixels_of(colours), kJpegQuality);
  if (!jpeg) return tl::unexpected(jpeg.error());
  return Picture{*std::move(jpeg), colours.cols, colours.rows};
}

}  // namespace strobe::lab_report
