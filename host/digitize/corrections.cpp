#include "host/digitize/corrections.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/config/toml_reader.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/image_order.hpp"

namespace strobe::digitize {

namespace {

using reduction::BallImage;
using Kind = Correction::Kind;

constexpr std::string_view kHand = "hand";

class Editor {
 public:
  Editor(const Digitization& found, const DigitizeSettings& settings, double px_per_m)
      : result_(found), settings_(settings), px_per_m_(px_per_m) {
    touched_.assign(found.frame.images.size(), nullptr);
  }

  Result<void> apply(const Correction& correction) {
    if (correction.kind == Kind::add) return add(correction);
    if (correction.kind == Kind::surface) return set_surface(correction);
    const auto index = image_at(correction);
    if (!index) return tl::unexpected(index.error());
    touched_[*index] = &correction;
    if (correction.kind == Kind::move) change(*index, correction.measured);
    return {};
  }

  Digitization finish() {
    if (result_.surface_by_hand) forget_legs();
    for (std::size_t i = touched_.size(); i-- > 0;) {
      if (touched_[i] != nullptr && touched_[i]->kind == Kind::remove) remove(i);
    }
    auto& images = result_.frame.images;
    images.insert(images.end(), added_.begin(), added_.end());
    result_.outlines.insert(result_.outlines.end(), added_outlines_.begin(), added_outlines_.end());
    order_images(result_.frame, result_.outlines, settings_, result_.remarks);
    if (result_.surface_by_hand) measure_contacts(result_);
    return std::move(result_);
  }

 private:
  cv::Point2d plane(const ManualPoint& p) const {
    return p.in_image ? settings_.map.to_plane(p.point) : p.point;
  }

  Result<void> set_surface(const Correction& correction) {
    cv::Point2d left = plane(correction.surface.left), right = plane(correction.surface.right);
    if (right.x < left.x) std::swap(left, right);
    constexpr double kMinLength_px = 1.0;
    if (!(cv::norm(right - left) >= kMinLength_px))
      return fail(correction.location + ": surface: left and right are the same point");
    result_.frame.surface_px = {{left.x, left.y}, {right.x, right.y}};
    result_.frame.surface_sd_px = hand_sd_px(correction.surface.sd_px);
    result_.surface_by_hand = true;
    result_.no_surface.reset();
    result_.remarks.push_back("the surface line is by hand (" + correction.location + ")");
    return {};
  }

  /// By another line other images are in contact; what a person says of one stays. Before any is removed.
  void forget_legs() {
    for (std::size_t i = 0; i < touched_.size(); ++i) {
      BallImage& image = result_.frame.images[i];
      const ManualMeasurement by_hand = touched_[i] != nullptr ? touched_[i]->measured : ManualMeasurement{};
      if (!by_hand.leg) image.leg.reset();
      if (!by_hand.top) image.top_px.reset();
      if (!by_hand.contact_width_px) image.contact_width_px.reset();
    }
    std::erase_if(result_.unmeasured, [](const Unmeasured& u) { return u.what == "top"; });
  }

  Result<std::size_t> image_at(const Correction& correction) const {
    const cv::Point2d at = plane(correction.at);
    const auto& images = result_.frame.images;
    std::optional<std::size_t> nearest;
    double least_px = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < images.size(); ++i) {
      const double distance_px = std::hypot(images[i].centre_px.x - at.x, images[i].centre_px.y - at.y);
      if (distance_px < least_px) least_px = distance_px, nearest = i;
    }
    const double reach_px = 0.5 * px_per_m_ * settings_.ball_diameter_m;
    if (!nearest || least_px > reach_px)
      return fail(fmt::format("{}: no image within {:.0f} px of ({:.1f}, {:.1f})", correction.location,
                              reach_px, at.x, at.y));
    if (touched_[*nearest] != nullptr)
      return fail(
          fmt::format("{}: means the same image as {}", correction.location, touched_[*nearest]->location));
    return *nearest;
  }

  double hand_sd_px(const std::optional<double>& stated) const {
    return stated.value_or(kManualCentre_sd_m * px_per_m_);
  }

  /// Two points of an outline make a diameter.
  double hand_diameter_sd_px(const std::optional<double>& stated) const {
    return stated.value_or(std::sqrt(2.0) * kManualCentre_sd_m * px_per_m_);
  }

  double plane_angle(const reduction::PointPx& centre, double image_rad) const {
    const cv::Point2d at = settings_.map.to_image({centre.x, centre.y});
    const cv::Vec2d along = settings_.map.jacobian(at) * cv::Vec2d(std::cos(image_rad), -std::sin(image_rad));
    return std::atan2(along[1], along[0]);
  }

  double plane_diameter(const reduction::PointPx& centre, const ManualMeasurement& m) const {
    if (!m.diameter_in_image) return *m.diameter_px;
    return *m.diameter_px / settings_.map.image_px_per_plane_px(settings_.map.to_image({centre.x, centre.y}));
  }

  void set_centre(BallImage& image, Outline& outline, const ManualMeasurement& m) const {
    outline.centre = plane(*m.centre);
    image.centre_px = {outline.centre.x, outline.centre.y};
    const double variance = std::pow(hand_sd_px(m.centre_sd_px), 2);
    image.centre_cov_px2 = {variance, 0.0, 0.0, variance};
  }

  void set_rest(BallImage& image, const ManualMeasurement& m) const {
    image.source = kHand;
    image.probability = 1.0;  // a person looked at it
    if (m.equator_rad) {
      image.equator_rad = m.equator_in_image ? plane_angle(image.centre_px, *m.equator_rad) : *m.equator_rad;
      image.equator_sd_rad = m.equator_sd_rad.value_or(kManualEquator_sd_rad);
    }
    if (m.no_equator) image.equator_rad.reset(), image.equator_sd_rad.reset();
    if (m.equator_rad || m.no_equator)
      image.equator_tilt_rad.reset(), image.equator_tilt_sd_rad.reset(),
          image.equator_tilt_correlation.reset();
    if (m.leg) image.leg = m.leg;
    if (m.top) {
      const cv::Point2d top = plane(*m.top);
      image.top_px = {top.x, top.y};
    }
    if (m.contact_width_px) image.contact_width_px = m.contact_width_px;
    if (m.time_s) image.time_s = *m.time_s;
  }

  void set_diameter(BallImage& image, Outline& outline, double diameter_px, double sd_px) const {
    outline.diameter = image.diameter_px = diameter_px;
    image.diameter_sd_px = sd_px;
  }

  /// An outline measured by hand is no longer fitted to the photograph.
  static void replace_fit(Outline& outline, const BallImage& image) {
    outline.visible_arcs.clear();
    outline.visible_fraction = 0.0;
    const auto& c = *image.centre_cov_px2;
    const double d = image.diameter_sd_px.value_or(0.0);
    outline.covariance = cv::Matx33d(c[0], c[1], 0.0, c[2], c[3], 0.0, 0.0, 0.0, d * d);
    outline.shared_diameter_sd_px = 0.0;
  }

  void change(std::size_t index, const ManualMeasurement& m) {
    BallImage& image = result_.frame.images[index];
    Outline& outline = result_.outlines[index];
    if (m.centre) set_centre(image, outline, m);
    if (m.diameter_px)
      set_diameter(image, outline, plane_diameter(image.centre_px, m), hand_diameter_sd_px(m.diameter_sd_px));
    if ((m.centre || m.diameter_px) && image.centre_cov_px2) replace_fit(outline, image);
    outline.probability = 1.0;
    set_rest(image, m);
  }

  Result<void> add(const Correction& correction) {
    const ManualMeasurement& m = correction.measured;
    BallImage image;
    Outline outline;
    image.time_s = std::numeric_limits<double>::quiet_NaN();
    set_centre(image, outline, m);
    if (m.diameter_px)
      set_diameter(image, outline, plane_diameter(image.centre_px, m), hand_diameter_sd_px(m.diameter_sd_px));
    else if (const auto [median, sd] = typical_diameter(); median > 0.0)
      set_diameter(image, outline, median, sd);
    else if (m.leg != reduction::Leg::contact)
      return fail(correction.location +
                  ": add.diameter_px: is missing, and there is no image to take it from");
    replace_fit(outline, image);
    set_rest(image, m);
    added_.push_back(image);
    added_outlines_.push_back(outline);
    return {};
  }

  /// Upper median of the airborne images, and an sd that covers half their range.
  std::pair<double, double> typical_diameter() const {
    std::vector<double> diameters;
    for (const BallImage& image : result_.frame.images) {
      if (image.leg != reduction::Leg::contact && image.diameter_px > 0.0)
        diameters.push_back(image.diameter_px);
    }
    if (diameters.empty()) return {0.0, 0.0};
    const auto [least, most] = std::ranges::minmax(diameters);
    return {upper_median(diameters), std::max(0.5 * (most - least), hand_diameter_sd_px({}))};
  }

  void remove(std::size_t index) {
    auto& images = result_.frame.images;
    const BallImage& image = images[index];
    result_.unmeasured.push_back({{image.centre_px.x, image.centre_px.y},
                                  image.diameter_px,
                                  "image",
                                  {Reason::by_hand, "removed by " + touched_[index]->location}});
    images.erase(images.begin() + static_cast<std::ptrdiff_t>(index));
    result_.outlines.erase(result_.outlines.begin() + static_cast<std::ptrdiff_t>(index));
  }

  Digitization result_;
  const DigitizeSettings& settings_;
  double px_per_m_;
  std::vector<const Correction*> touched_;
  std::vector<BallImage> added_;
  std::vector<Outline> added_outlines_;
};

}  // namespace

Result<void> apply_corrections(Digitization& digitization, const std::vector<Correction>& corrections,
                               const DigitizeSettings& settings) {
  const auto& found = digitization.scale;
  const auto px_per_m = settings.px_per_m ? settings.px_per_m
                        : found           ? std::optional(found->px_per_m)
                                          : std::nullopt;
  if (!px_per_m && !corrections.empty())
    return fail(corrections.front().location +
                ": without a scale and without an image that was found, none can be corrected");
  Editor editor(digitization, settings, px_per_m.value_or(0.0));
  for (const Correction& correction : corrections) {
    if (auto applied = editor.apply(correction); !applied) return applied;
  }
  digitization = editor.finish();
  return {};
}

namespace {

using config::Range;
using config::TomlTable;

constexpr Range kPixels{-1e6, 1e6};
constexpr Range kLength{0.1, 1e5};
constexpr Range kSd{1e-4, 1e4};

std::optional<ManualPoint> point(TomlTable& table, const std::string& name) {
  std::optional<ManualPoint> found;
  for (const bool in_image : {false, true}) {
    const std::string key = name + (in_image ? "_image_px" : "_px");
    if (!table.has(key)) continue;
    const auto numbers = table.numbers_or(key, {}, kPixels);
    if (numbers.size() != 2) {
      table.error_at(key, "must be two numbers");
      continue;
    }
    if (found) table.error_at(key, "is there twice: " + name + "_px says it already");
    found = ManualPoint{{numbers[0], numbers[1]}, in_image};
  }
  return found;
}

std::optional<double> angle(TomlTable& table, std::string_view key, Range range) {
  auto degrees = table.optional_number(key, range);
  if (degrees) *degrees *= std::numbers::pi / 180.0;
  return degrees;
}

std::optional<reduction::Leg> leg(TomlTable& table) {
  if (!table.has("leg")) return std::nullopt;
  const std::string word = table.choice_or("leg", "", {"incoming", "contact", "rebound"});
  if (word == "incoming") return reduction::Leg::incoming;
  return word == "contact" ? reduction::Leg::contact : reduction::Leg::rebound;
}

/// A number of the frame, NAME_px or NAME_deg, or of the photograph, NAME_image_px or NAME_image_deg.
std::optional<double> of_frame_or_image(TomlTable& table, const std::string& name, const std::string& unit,
                                        Range range, bool& in_image) {
  const std::string frame = name + "_" + unit, image = name + "_image_" + unit;
  auto value = table.optional_number(frame, range);
  if (!table.has(image)) return value;
  if (value) table.error_at(image, "is there twice: " + frame + " says it already");
  in_image = true;
  return table.optional_number(image, range);
}

ManualSurface surface(TomlTable& table) {
  ManualSurface line;
  for (const auto& [name, end] : {std::pair{"left", &line.left}, std::pair{"right", &line.right}}) {
    if (const auto at = point(table, name))
      *end = *at;
    else
      table.error_at("", fmt::format("{0}_px (or {0}_image_px) is missing", name));
  }
  line.sd_px = table.optional_number("sd_px", kSd);
  return line;
}

ManualMeasurement measurement(TomlTable& table) {
  ManualMeasurement measured;
  measured.centre = point(table, "centre");
  measured.centre_sd_px = table.optional_number("centre_sd_px", kSd);
  measured.diameter_px = of_frame_or_image(table, "diameter", "px", kLength, measured.diameter_in_image);
  measured.diameter_sd_px = table.optional_number("diameter_sd_px", kSd);
  measured.equator_rad =
      of_frame_or_image(table, "equator", "deg", {-360.0, 360.0}, measured.equator_in_image);
  if (measured.equator_rad) *measured.equator_rad *= std::numbers::pi / 180.0;
  measured.equator_sd_rad = angle(table, "equator_sd_deg", {1e-3, 90.0});
  measured.no_equator = table.boolean_or("no_equator", false);
  measured.leg = leg(table);
  measured.top = point(table, "top");
  measured.contact_width_px = table.optional_number("contact_width_px", kLength);
  measured.time_s = table.optional_number("time_s", {-1e9, 1e9});
  const auto needs = [&table](bool sd, bool value, const char* sd_key, const char* what) {
    if (sd && !value) table.error_at(sd_key, std::string("is nothing without ") + what);
  };
  needs(measured.centre_sd_px.has_value(), measured.centre.has_value(), "centre_sd_px", "centre_px");
  needs(measured.diameter_sd_px.has_value(), measured.diameter_px.has_value(), "diameter_sd_px",
        "diameter_px");
  needs(measured.equator_sd_rad.has_value(), measured.equator_rad.has_value(), "equator_sd_deg",
        "equator_deg");
  if (measured.no_equator && measured.equator_rad) table.error_at("no_equator", "contradicts equator_deg");
  return measured;
}

bool is_empty(const ManualMeasurement& m) {
  return !m.centre && !m.diameter_px && !m.equator_rad && !m.no_equator && !m.leg && !m.top &&
         !m.contact_width_px && !m.time_s;
}

Correction read(TomlTable& table, Correction::Kind kind, const std::string& file_name) {
  Correction correction;
  correction.kind = kind;
  correction.location = fmt::format("{}:{}", file_name, table.line_of(""));
  if (kind != Correction::Kind::add) {
    if (const auto at = point(table, "at"))
      correction.at = *at;
    else
      table.error_at("", "at_px (or at_image_px) is missing");
  }
  if (kind == Correction::Kind::remove) return correction;
  correction.measured = measurement(table);
  if (kind == Correction::Kind::add && !correction.measured.centre)
    table.error_at("", "centre_px (or centre_image_px) is missing");
  if (kind == Correction::Kind::move && is_empty(correction.measured))
    table.error_at("", "says nothing to change");
  return correction;
}

}  // namespace

Result<std::vector<Correction>> parse_corrections(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  TomlTable root = reader.root();
  std::vector<Correction> corrections;
  const auto read_all = [&](std::string_view key, Correction::Kind kind) {
    for (TomlTable& table : root.tables(key)) corrections.push_back(read(table, kind, file_name));
  };
  read_all("remove", Correction::Kind::remove);
  read_all("move", Correction::Kind::move);
  read_all("add", Correction::Kind::add);
  if (TomlTable table = root.table("surface"); table.present()) {
    Correction& correction = corrections.emplace_back();
    correction.kind = Correction::Kind::surface;
    correction.location = fmt::format("{}:{}", file_name, table.line_of(""));
    correction.surface = surface(table);
  }
  if (auto error = reader.error()) return tl::unexpected(*error);
  if (corrections.empty()) return fail(file_name + ": no [[add]], [[move]], [[remove]] or [surface]");
  return corrections;
}

}  // namespace strobe::digitize
