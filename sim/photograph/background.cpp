#include "sim/photograph/background.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

constexpr int kCoarse = 4;  // the wall is out of focus anyway
constexpr int kFraction = 4;
constexpr double kFixed = 1 << kFraction;
constexpr int kPiecesOfASide = 16;  // a straight side through a lens that bends it

/// Draws shapes in axis coordinates on a map of light at 1/step of the sensor's resolution.
class Stage {
 public:
  Stage(const Optics& optics, cv::Mat& light, int step) : optics_(optics), light_(light), step_(step) {}

  /// Mixes light into a convex polygon (corners counter-clockwise): all of it at a share of 1. The edges are
  /// where the corners say, to a small part of a pixel; blurred edges fall over 5 sd of the blur.
  void polygon(const std::vector<Vec2>& corners, double z, double brightness, double share, double blur_px) {
    const double nearer = optics_.perspective() ? optics_.distance_m() / (optics_.distance_m() - z) : 1.0;
    std::vector<Vec2> seen;
    for (const Vec2& c : corners) seen.push_back({nearer * c.x, nearer * c.y});
    std::vector<cv::Point> outline;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Vec2 &a = seen[i], &b = seen[(i + 1) % seen.size()];
      for (int k = 0; k < kPiecesOfASide; ++k) {
        const double t = static_cast<double>(k) / kPiecesOfASide;
        outline.push_back(fixed({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, 0.0));
      }
    }
    const cv::Rect box = within(outline, blur_px);
    const double per_m = optics_.px_per_m() / step_;
    const double fall_px = 1.0 + 5.0 * blur_px;
    for (int row = box.y; row < box.y + box.height; ++row) {
      float* l = light_.ptr<float>(row);
      for (int column = box.x; column < box.x + box.width; ++column) {
        const double covered = std::clamp(0.5 - per_m * outside(seen, at(column, row)) / fall_px, 0.0, 1.0);
        l[column] += static_cast<float>(share * covered) * (static_cast<float>(brightness) - l[column]);
      }
    }
  }

  void stroke(const std::vector<Vec2>& way, double z, double width_m, double brightness) {
    std::vector<cv::Point> points;
    for (const Vec2& p : way) points.push_back(fixed(p, z));
    const double width_px = std::max(1.0, width_m * optics_.px_per_m() / step_);
    const cv::Rect box = within(points, width_px);
    if (box.empty()) return;
    cv::Mat mask = cv::Mat::zeros(box.size(), CV_8UC1);
    const cv::Point shift(-box.x * static_cast<int>(kFixed), -box.y * static_cast<int>(kFixed));
    for (cv::Point& p : points) p += shift;
    cv::polylines(mask, points, false, cv::Scalar(255), cvRound(width_px), cv::LINE_AA, kFraction);
    mix(mask, box, brightness);
  }

  Vec2 at(int column, int row) const {
    return optics_.plane_at((column + 0.5) * step_ - 0.5, (row + 0.5) * step_ - 0.5);
  }
  cv::Mat& light() { return light_; }
  const Optics& optics() const { return optics_; }
  int step() const { return step_; }

 private:
  cv::Point fixed(const Vec2& p, double z) const {
    const Vec2 pixel = optics_.image_of({p.x, p.y, z});
    const auto scaled = [&](double x) {
      return cvRound(std::clamp(((x + 0.5) / step_ - 0.5) * kFixed, -1e8, 1e8));
    };
    return {scaled(pixel.x), scaled(pixel.y)};
  }
  cv::Rect within(const std::vector<cv::Point>& points, double margin) const {
    const int m = 2 + static_cast<int>(4.0 * margin);
    int left = 1 << 30, top = 1 << 30, right = -(1 << 30), bottom = -(1 << 30);
    for (const cv::Point& p : points) {
      left = std::min(left, p.x);
      right = std::max(right, p.x);
      top = std::min(top, p.y);
      bottom = std::max(bottom, p.y);
    }
    const auto floored = [&](int x) { return static_cast<int>(std::floor(x / kFixed)); };
    const cv::Rect box(floored(left) - m, floored(top) - m, floored(right) - floored(left) + 2 * m + 1,
                       floored(bottom) - floored(top) + 2 * m + 1);
    return box & cv::Rect(0, 0, light_.cols, light_.rows);
  }
  /// How far a point lies outside of the polygon; negative inside.
  static double outside(const std::vector<Vec2>& corners, const Vec2& p) {
    double most = -1e9;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
      const double dx = b.x - a.x, dy = b.y - a.y;
      most = std::max(most, (dy * (p.x - a.x) - dx * (p.y - a.y)) / std::hypot(dx, dy));
    }
    return most;
  }
  void mix(cv::Mat& mask, const cv::Rect& box, double brightness) {
    cv::GaussianBlur(mask, mask, {}, 0.7);
    for (int row = 0; row < box.height; ++row) {
      const std::uint8_t* m = mask.ptr<std::uint8_t>(row);
      float* l = light_.ptr<float>(box.y + row) + box.x;
      for (int column = 0; column < box.width; ++column)
        l[column] += static_cast<float>(m[column] / 255.0) * (static_cast<float>(brightness) - l[column]);
    }
  }

  const Optics& optics_;
  cv::Mat& light_;
  int step_;
};

std::vector<Vec2> rectangle(double left, double right, double bottom, double top) {
  return {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
}

class Set {
 public:
  Set(const Scene& scene, const Appearance& appearance)
      : scene_(scene),
        appearance_(appearance),
        optics_(scene),
        draws_(appearance.background.clutter, Purpose::appearance, 1),
        half_width_m_(scene.camera.half_width_m),
        height_m_(scene.camera.height_m) {}

  const Optics& optics() const { return optics_; }

  void wall(Stage& stage) {
    const ValueNoise noise(appearance_.background.clutter);
    for (int row = 0; row < stage.light().rows; ++row) {
      float* l = stage.light().ptr<float>(row);
      for (int column = 0; column < stage.light().cols; ++column) {
        const Vec2 p = stage.at(column, row);
        const double ramp = 1.0 + appearance_.background.wall_ramp * p.x / half_width_m_;
        const double stains =
            1.0 + 0.25 * noise.at(6.0 * p.x, 6.0 * p.y) + 0.08 * noise.at(40.0 * p.x, 40.0 * p.y);
        l[column] = static_cast<float>(appearance_.background.wall * std::max(0.1, ramp) * stains);
      }
    }
    const double z = -scene_.background.wall_distance_m;
    for (int i = count(4.0); i > 0; --i) panel(stage, z);
    for (int i = count(3.0); i > 0; --i) cable(stage, z);
  }

  /// Each flash leaves the shadow of its ball under each lamp unlit.
  void shadows(Stage& stage, const std::vector<BallImageOnSensor>& images, const std::array<double, 2>& all) {
    if (all[0] + all[1] <= 0.0) return;
    for (const BallImageOnSensor& image : images) {
      for (std::size_t lamp = 0; lamp < 2; ++lamp) {
        const double share = image.middle.light[lamp] / (all[0] + all[1]);
        if (share > 0.0) shadow(stage, image.middle.centre, appearance_.lamps[lamp], share);
      }
    }
  }

  void plate(Stage& stage) {
    if (!scene_.background.plate) return;
    const double y = optics_.surface_y();
    const double x = appearance_.background.plate_half_length_m;
    const double thick = appearance_.background.plate_thickness_m;
    const double light = appearance_.background.plate_brightness;
    const double near = 0.5 * scene_.background.plate_depth_m;
    const double front = optics_.perspective() ? std::min(near, 0.5 * optics_.distance_m()) : 0.0;
    for (int i = count(4.0); i > 0; --i) block(stage, y - thick);
    if (front > 0.0) {
      // Its upper side, from its far edge to its near one.
      const double far_x = x * seen(-front), near_x = x * seen(front);
      stage.polygon({{-near_x, y * seen(front)},
                     {near_x, y * seen(front)},
                     {far_x, y * seen(-front)},
                     {-far_x, y * seen(-front)}},
                    0.0, 0.7 * light, 1.0, 0.0);
    }
    stage.polygon(rectangle(-x, x, y - thick, y), front, light, 1.0, 0.0);
    scratches(stage, y, x, thick, front);
    for (const double side : {-1.0, 1.0}) clamp(stage, side, x, y, thick);
  }

  void reflections(Stage& stage) {
    for (int i = count(5.0); i > 0; --i) {
      const Vec2 c = somewhere();
      const double length = 0.005 + 0.06 * draws_.uniform();
      const double width = 0.0008 + 0.004 * draws_.uniform();
      const double angle = std::numbers::pi * draws_.uniform();
      const double brightness = std::exp(-2.5 * draws_.uniform());
      turned(stage, c, length, width, angle, brightness, 0.4 + 4.0 * draws_.uniform());
    }
    for (int i = 0; i < scene_.background.blobs; ++i) blob(stage);
  }

 private:
  /// How many, for `most` at a clutter of 1.
  int count(double most) {
    return static_cast<int>(most * scene_.background.clutter * 2.0 * draws_.uniform());
  }
  double seen(double z) const { return optics_.distance_m() / (optics_.distance_m() - z); }
  Vec2 somewhere() {
    const double x = half_width_m_ * (2.2 * draws_.uniform() - 1.1);
    return {x, height_m_ * (1.05 * draws_.uniform() - 0.5)};
  }

  void panel(Stage& stage, double z) {
    const Vec2 c = somewhere();
    const double w = 0.02 + 0.15 * draws_.uniform(), h = 0.05 + 0.4 * draws_.uniform();
    const double brightness = appearance_.background.wall * 3.0 * draws_.uniform();
    stage.polygon(rectangle(c.x - w, c.x + w, c.y - h, c.y + h), z, brightness, 1.0, 0.5 + draws_.uniform());
  }

  void cable(Stage& stage, double z) {
    const Vec2 a = somewhere(), b = somewhere();
    const double sag = 0.1 * draws_.uniform();
    std::vector<Vec2> way;
    for (int k = 0; k <= 40; ++k) {
      const double t = k / 40.0;
      way.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y) - 4.0 * sag * t * (1.0 - t)});
    }
    const double width = 0.002 + 0.006 * draws_.uniform();
    stage.stroke(way, z, width, appearance_.background.wall * (draws_.uniform() < 0.5 ? 0.1 : 4.0));
  }

  void shadow(Stage& stage, const Vec3& ball, const LampAppearance& lamp, double share) {
    const double depth = ball.z + scene_.background.wall_distance_m;
    const double t = depth / (lamp.place.z - ball.z);
    if (t <= 0.0) return;
    const Vec3 place = ball + t * (ball - lamp.place);
    const double radius = scene_.ball.radius_m() * (1.0 + t);
    const double soft = std::max(lamp.radius_m * t, 0.002);
    const double shrink = optics_.perspective() ? seen(place.z) : 1.0;
    const Vec2 c{shrink * place.x, shrink * place.y};
    const Vec2 on_sensor = optics_.image_of(place);
    const double reach_px = shrink * (radius + soft) * optics_.px_per_m() / stage.step() + 3.0;
    const double column = on_sensor.x / stage.step(), row = on_sensor.y / stage.step();
    const cv::Rect box = cv::Rect(cvFloor(column - reach_px), cvFloor(row - reach_px), cvCeil(2.0 * reach_px),
                                  cvCeil(2.0 * reach_px)) &
                         cv::Rect(0, 0, stage.light().cols, stage.light().rows);
    for (int j = box.y; j < box.y + box.height; ++j) {
      float* l = stage.light().ptr<float>(j);
      for (int i = box.x; i < box.x + box.width; ++i) {
        const Vec2 p = stage.at(i, j);
        const double away = std::hypot(p.x - c.x, p.y - c.y) / shrink;
        const double dark = std::clamp(0.5 - (away - radius) / (2.0 * soft), 0.0, 1.0);
        l[i] *= static_cast<float>(1.0 - share * dark * dark * (3.0 - 2.0 * dark));
      }
    }
  }

  void block(Stage& stage, double top) {
    const double x = half_width_m_ * (2.0 * draws_.uniform() - 1.0);
    const double w = 0.02 + 0.05 * draws_.uniform();
    const double brightness = appearance_.background.plate_brightness * 0.4 * draws_.uniform();
    stage.polygon(rectangle(x - w, x + w, top - 0.2, top + 0.002), 0.0, brightness, 1.0, 0.6);
  }

  /// Uneven light along the plate's front.
  void scratches(Stage& stage, double y, double x, double thick, double z) {
    for (int i = count(12.0); i > 0; --i) {
      const double left = x * (2.0 * draws_.uniform() - 1.0);
      const double right = std::min(x, left + 0.001 + 0.04 * draws_.uniform());
      const double brightness = appearance_.background.plate_brightness * (0.6 + 0.8 * draws_.uniform());
      const double low = y - thick * (0.1 + 0.9 * draws_.uniform());
      stage.polygon(rectangle(left, right, low, y - 0.05 * thick), z, brightness, 0.7, 0.8);
    }
  }

  /// At the plate's ends, outside of where balls fly low.
  void clamp(Stage& stage, double side, double end, double y, double thick) {
    const double inner = side * std::max(half_width_m_ * 1.02, end - 0.01 - 0.03 * draws_.uniform());
    const double outer = inner + side * (0.02 + 0.05 * draws_.uniform());
    const double up = y + 0.004 + 0.03 * draws_.uniform();
    const double brightness = 0.05 + 2.0 * draws_.uniform() * draws_.uniform();
    if (scene_.background.clutter <= 0.0 || draws_.uniform() > 0.5 + 0.5 * scene_.background.clutter) return;
    stage.polygon(rectangle(std::min(inner, outer), std::max(inner, outer), y - thick - 0.02, up), 0.0,
                  brightness, 1.0, 0.0);
  }

  void turned(Stage& stage, const Vec2& c, double length, double width, double angle, double brightness,
              double blur_px) {
    std::vector<Vec2> corners;
    const double u = std::cos(angle), v = std::sin(angle);
    for (const auto& [a, b] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
      corners.push_back({c.x + a * length * u - b * width * v, c.y + a * length * v + b * width * u});
    stage.polygon(corners, 0.0, brightness, 1.0, blur_px);
  }

  /// An oval of up to a ball's size, sharp or soft.
  void blob(Stage& stage) {
    const Vec2 c = somewhere();
    const double a = scene_.ball.radius_m() * (0.15 + 0.85 * draws_.uniform());
    const double b = a * (0.4 + 0.6 * draws_.uniform());
    const double angle = std::numbers::pi * draws_.uniform();
    std::vector<Vec2> oval;
    for (int k = 0; k < 32; ++k) {
      const double t = 2.0 * std::numbers::pi * k / 32;
      const double x = a * std::cos(t), y = b * std::sin(t);
      oval.push_back(
          {c.x + x * std::cos(angle) - y * std::sin(angle), c.y + x * std::sin(angle) + y * std::cos(angle)});
    }
    const double brightness = 0.3 + 1.2 * draws_.uniform();
    stage.polygon(oval, 0.0, brightness, 1.0, 0.3 + 8.0 * draws_.uniform() * draws_.uniform());
  }

  const Scene& scene_;
  const Appearance& appearance_;
  Optics optics_;
  Draws draws_;
  double half_width_m_;
  double height_m_;
};

}  // namespace

cv::Mat render_background(const Scene& scene, const Appearance& appearance,
                          const std::vector<BallImageOnSensor>& images,
                          const std::array<double, 2>& light_of_all) {
  Set set(scene, appearance);
  const SensorSize size = set.optics().sensor();
  cv::Mat coarse((size.height + kCoarse - 1) / kCoarse, (size.width + kCoarse - 1) / kCoarse, CV_32FC1);
  Stage wall(set.optics(), coarse, kCoarse);
  set.wall(wall);
  set.shadows(wall, images, light_of_all);
  cv::Mat light;
  cv::resize(coarse, light, {coarse.cols * kCoarse, coarse.rows * kCoarse}, 0.0, 0.0, cv::INTER_LINEAR);
  light = light(cv::Rect(0, 0, size.width, size.height)).clone();
  Stage scenery(set.optics(), light, 1);
  set.plate(scenery);
  set.reflections(scenery);
  return light;
}

}  // namespace strobe::sim
