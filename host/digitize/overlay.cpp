#include "host/digitize/overlay.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/config/files.hpp"
#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"

namespace strobe::digitize {
namespace {

float quantile_of(const std::vector<float>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

cv::Mat display_grey(const cv::Mat& intensity, double white_number) {
  constexpr int kSamplesAcross = 400;
  const int step = std::max(1, std::max(intensity.cols, intensity.rows) / kSamplesAcross);
  std::vector<float> samples;
  for (int row = 0; row < intensity.rows; row += step) {
    for (int column = 0; column < intensity.cols; column += step)
      samples.push_back(intensity.at<float>(row, column));
  }
  std::ranges::sort(samples);
  const float black = quantile_of(samples, 0.01);
  const float white = std::max(quantile_of(samples, 0.998), black + 1e-4F);
  cv::Mat shown = (intensity - black) * (1.0F / (white - black));
  shown = cv::min(cv::max(shown, 0.0F), 1.0F);
  cv::sqrt(shown, shown);
  cv::Mat grey;
  shown.convertTo(grey, CV_8U, white_number);
  return grey;
}

namespace {

using reduction::BallImage;
using reduction::Leg;

const cv::Scalar kIncoming(255, 190, 60);
const cv::Scalar kContact(40, 220, 255);
const cv::Scalar kRebound(90, 235, 90);
const cv::Scalar kUnknown(230, 230, 230);
const cv::Scalar kByHand(255, 80, 255);
const cv::Scalar kSurface(30, 150, 255);
const cv::Scalar kRejected(70, 70, 255);

constexpr int kShift = 4;  // of OpenCV's fixed-point coordinates

constexpr double kWhite = 215.0;  // leaves room for what is drawn

cv::Scalar colour_of(const BallImage& image) {
  if (image.source == "hand") return kByHand;
  if (!image.leg) return kUnknown;
  return *image.leg == Leg::incoming ? kIncoming : *image.leg == Leg::contact ? kContact : kRebound;
}

class Canvas {
 public:
  Canvas(const Photograph& photograph, const PlaneMap& map, int longest_side_px) : map_(map) {
    const int longest = std::max(photograph.width(), photograph.height());
    cv::Mat intensity = photograph.intensity;
    if (longest > longest_side_px) {
      scale_ = static_cast<double>(longest_side_px) / longest;
      cv::resize(intensity, intensity, cv::Size(), scale_, scale_, cv::INTER_AREA);
    }
    cv::cvtColor(display_grey(intensity, kWhite), picture_, cv::COLOR_GRAY2BGR);
    text_scale_ = std::clamp(std::max(picture_.cols, picture_.rows) / 2900.0, 0.4, 1.2);
  }

  cv::Mat picture() const { return picture_; }

  void curve(const std::vector<cv::Point2d>& plane_px, bool closed, const cv::Scalar& colour, int thickness) {
    std::vector<cv::Point> points;
    for (const cv::Point2d& p : plane_px) {
      const cv::Point2d at = on_canvas(p);
      if (!drawable(at)) return;
      points.emplace_back(cvRound(at.x * (1 << kShift)), cvRound(at.y * (1 << kShift)));
    }
    cv::polylines(picture_, points, closed, colour, thickness, cv::LINE_AA, kShift);
  }

  void ellipse(const EllipsePx& e, const cv::Scalar& colour, int thickness) {
    constexpr int kPoints = 180;
    std::vector<cv::Point2d> points;
    for (int i = 0; i < kPoints; ++i) {
      const double turn = 2.0 * std::numbers::pi * i / kPoints;
      const double u = e.along * std::cos(turn);
      const double v = e.across * std::sin(turn);
      const double c = std::cos(e.axis_rad);
      const double s = std::sin(e.axis_rad);
      points.emplace_back(e.centre.x + c * u - s * v, e.centre.y + s * u + c * v);
    }
    curve(points, true, colour, thickness);
  }

  void cross(cv::Point2d centre, double half_px, const cv::Scalar& colour) {
    curve({{centre.x - half_px, centre.y}, {centre.x + half_px, centre.y}}, false, colour, 1);
    curve({{centre.x, centre.y - half_px}, {centre.x, centre.y + half_px}}, false, colour, 1);
  }

  /// Near the anchor, where it overlaps no other label; with a leader line if it is not close.
  void label(const std::string& text, cv::Point2d anchor, double diameter_px, const cv::Scalar& colour,
             double size = 1.0) {
    const cv::Point2d at = on_canvas(anchor);
    if (!drawable(at)) return;
    const double scale = text_scale_ * size;
    int below = 0;
    const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &below);
    const double step = diameter_px * scale_;
    const cv::Rect best = free_place(at, box, below, step);
    taken_.push_back(best);
    const cv::Point2d middle(best.x + 0.5 * best.width, best.y + 0.5 * best.height);
    if (cv::norm(middle - at) > 0.3 * step) cv::line(picture_, at, middle, colour, 1, cv::LINE_AA);
    const cv::Point foot(best.x, best.y + box.height);
    cv::putText(picture_, text, foot, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(0, 0, 0), 5, cv::LINE_AA);
    cv::putText(picture_, text, foot, cv::FONT_HERSHEY_SIMPLEX, scale, colour, thickness(), cv::LINE_AA);
  }

  int thickness() const { return text_scale_ > 0.6 ? 2 : 1; }

 private:
  cv::Point2d on_canvas(cv::Point2d plane_px) const {
    const cv::Point2d p = map_.to_image(plane_px);
    return {(p.x + 0.5) * scale_ - 0.5, (p.y + 0.5) * scale_ - 0.5};
  }

  /// OpenCV's fixed-point coordinates overflow far outside.
  static bool drawable(cv::Point2d p) { return std::abs(p.x) < 5e4 && std::abs(p.y) < 5e4; }

  /// The least costly place for a text around `at`. `below`: the text's height under its baseline.
  cv::Rect free_place(cv::Point2d at, cv::Size box, int below, double step) const {
    cv::Rect best;
    double least = 1e300;
    for (const cv::Point2d& shift : kShifts) {
      const cv::Point corner(cvRound(at.x + shift.x * step - 0.5 * box.width),
                             cvRound(at.y + shift.y * step - 0.5 * box.height));
      const cv::Rect place(corner, cv::Size(box.width, box.height + below));
      const double cost = cost_of(place) + 0.02 * box.area() * cv::norm(shift);
      if (cost < least) least = cost, best = place;
    }
    return best;
  }

  double cost_of(const cv::Rect& place) const {
    double cost = 3.0 * (place.area() - (place & cv::Rect({}, picture_.size())).area());
    for (const cv::Rect& other : taken_) cost += (place & other).area();
    return cost;
  }

  /// In diameters, from the anchor.
  static inline const std::vector<cv::Point2d> kShifts{
      {0, -0.1},   {0, 0.15},   {0, -0.3},    {0, 0.35},    {0, -0.6},   {0, 0.6},
      {-0.7, 0},   {0.7, 0},    {-0.6, 0.5},  {0.6, -0.5},  {0.6, 0.5},  {-0.6, -0.5},
      {0, -0.9},   {0, 0.9},    {-1.1, 0.3},  {1.1, 0.3},   {0, 1.2},    {-0.8, -0.9},
      {0.8, -0.9}, {0.8, 0.95}, {-0.8, 0.95}, {-0.9, 1.25}, {0.9, 1.25}, {0, -1.2}};

  const PlaneMap& map_;
  double scale_ = 1.0;
  cv::Mat picture_;
  double text_scale_ = 1.0;
  std::vector<cv::Rect> taken_;
};

void draw_surface(Canvas& canvas, const Digitization& digitization) {
  const cv::Scalar& colour = digitization.surface_by_hand ? kByHand : kSurface;
  std::vector<cv::Point2d> points;
  for (const auto& p : digitization.frame.surface_px) points.emplace_back(p.x, p.y);
  if (points.size() >= 2) canvas.curve(points, false, colour, canvas.thickness());
  for (const cv::Point2d& p : points) canvas.cross(p, 12.0, colour);
}

/// A short line at a contact image's top.
void draw_top(Canvas& canvas, const BallImage& image, const cv::Scalar& colour) {
  if (!image.top_px) return;
  const cv::Point2d top(image.top_px->x, image.top_px->y);
  canvas.curve({{top.x - 25, top.y}, {top.x + 25, top.y}}, false, colour, canvas.thickness());
}

/// Both ends of the line as it is seen, and a little beyond.
void draw_line(Canvas& canvas, const BallImage& image, const cv::Scalar& colour) {
  if (!image.equator_rad) return;
  constexpr double kFrom = 0.25, kBeyond = 1.12;  // radii
  constexpr int kPoints = 24;
  const cv::Point2d centre(image.centre_px.x, image.centre_px.y);
  const double half = 0.5 * image.diameter_px, sine = std::sin(image.equator_tilt_rad.value_or(0.0));
  const cv::Point2d along(half * std::cos(*image.equator_rad), half * std::sin(*image.equator_rad));
  const cv::Point2d left(-along.y * sine, along.x * sine);
  for (const double end : {-1.0, 1.0}) {
    std::vector<cv::Point2d> points{centre + end * kBeyond * along};
    for (int k = 0; k <= kPoints; ++k) {
      const double turn = std::asin(kFrom) * k / kPoints + 0.5 * std::numbers::pi * (kPoints - k) / kPoints;
      points.push_back(centre + end * std::sin(turn) * along + std::cos(turn) * left);
    }
    canvas.curve(points, false, colour, 1);
  }
}

void draw_image(Canvas& canvas, const PlaneMap& map, const BallImage& image) {
  const cv::Point2d centre(image.centre_px.x, image.centre_px.y);
  const cv::Scalar colour = colour_of(image);
  if (image.diameter_px > 0.0)
    canvas.ellipse(map.outline(centre, image.diameter_px), colour, canvas.thickness());
  canvas.cross(centre, 8.0, colour);
  draw_top(canvas, image, colour);
  draw_line(canvas, image, colour);
}

std::string label_of(const BallImage& image, std::size_t index) {
  if (!std::isfinite(image.time_s)) return fmt::format("{}", index + 1);
  return fmt::format("{}: {:.2f} ms", index + 1, image.time_s * 1e3);
}

/// `picture` has blue first.
Result<std::vector<std::uint8_t>> encoded(const cv::Mat& picture, const std::filesystem::path& extension) {
  cv::Mat colours;
  cv::cvtColor(picture, colours, cv::COLOR_BGR2RGB);
  const image::Pixels pixels = image::pixels_of(colours);
  std::string kind = extension.string();
  std::ranges::transform(kind, kind.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (kind == ".png") return image::encode_png(pixels);
  if (kind == ".jpg" || kind == ".jpeg") return image::encode_jpeg(pixels);
  if (kind == ".tif" || kind == ".tiff") return image::encode_tiff(pixels, {.lzw = true});
  return fail("cannot be written (an extension is needed: .png, .jpg or .tif)");
}

}  // namespace

cv::Mat draw_overlay(const Photograph& photograph, const PlaneMap& map, const Digitization& digitization,
                     const OverlaySettings& settings) {
  Canvas canvas(photograph, map, settings.longest_side_px);
  const auto& images = digitization.frame.images;
  draw_surface(canvas, digitization);
  if (settings.rejected) {
    for (const Unmeasured& u : digitization.unmeasured) {
      if (u.what == "image") canvas.ellipse(map.outline(u.centre, u.diameter), kRejected, 1);
    }
  }
  for (const BallImage& image : images) draw_image(canvas, map, image);
  for (std::size_t i = 0; i < images.size(); ++i) {
    canvas.label(label_of(images[i], i), {images[i].centre_px.x, images[i].centre_px.y},
                 images[i].diameter_px, colour_of(images[i]));
  }
  if (settings.rejected) {
    for (const Unmeasured& u : digitization.unmeasured) {
      const std::string prefix = u.what == "image" ? "" : u.what + ": ";
      canvas.label(prefix + std::string(name(u.why.reason)), u.centre, u.diameter, kRejected, 0.6);
    }
  }
  return canvas.picture();
}

Result<void> write_overlay(const std::filesystem::path& path, const Photograph& photograph,
                           const PlaneMap& map, const Digitization& digitization,
                           const OverlaySettings& settings) {
  const auto bytes = encoded(draw_overlay(photograph, map, digitization, settings), path.extension());
  if (!bytes) return fail(path.string() + ": " + bytes.error().message);
  return config::write_file(path, {reinterpret_cast<const char*>(bytes->data()), bytes->size()});
}

}  // namespace strobe::digitize
