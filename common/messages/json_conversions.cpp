#include "common/messages/json_conversions.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "common/messages/air_law_json.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::messages {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using reduction::BallImage;
using reduction::Frame;
using reduction::Leg;
using reduction::PointPx;

/// Reads fields of one object; remembers the first that is wrong.
class Fields {
 public:
  Fields(const json& object, std::string place, std::optional<Error>& error)
      : object_(object), place_(std::move(place)), error_(error) {}

  const json* find(const char* key) const {
    const auto it = object_.find(key);
    return it == object_.end() || it->is_null() ? nullptr : &*it;
  }
  const json* need(const char* key) {
    const json* value = find(key);
    if (!value) wrong(key, "is missing");
    return value;
  }
  void wrong(const std::string& key, const std::string& what) {
    if (!error_) error_ = Error{place_ + key + ": " + what};
  }

  void number(const char* key, double& into) {
    if (const json* value = need(key)) take_number(key, *value, into);
  }
  void number(const char* key, std::optional<double>& into) {
    const json* value = find(key);
    if (value) take_number(key, *value, into.emplace());
  }
  void integer(const char* key, int& into) {
    const json* value = find(key);
    if (value) take_integer(key, *value, into);
  }
  void integer(const char* key, std::optional<int>& into) {
    const json* value = find(key);
    if (value) take_integer(key, *value, into.emplace());
  }
  void text(const char* key, std::string& into) {
    const json* value = find(key);
    if (!value) return;
    if (!value->is_string()) return wrong(key, "must be text");
    into = value->get<std::string>();
  }
  void boolean(const char* key, bool& into) {
    const json* value = find(key);
    if (!value) return;
    if (!value->is_boolean()) return wrong(key, "must be true or false");
    into = value->get<bool>();
  }
  void point(const std::string& key, const json& value, PointPx& into) {
    if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) {
      return wrong(key, "must be two numbers");
    }
    into = {value[0].get<double>(), value[1].get<double>()};
  }
  bool failed() const { return error_.has_value(); }

 private:
  void take_number(const char* key, const json& value, double& into) {
    if (!value.is_number()) return wrong(key, "must be a number");
    into = value.get<double>();
  }
  void take_integer(const char* key, const json& value, int& into) {
    const bool fits =
        value.is_number_unsigned()
            ? value.get<std::uint64_t>() <= std::numeric_limits<int>::max()
            : value.is_number_integer() && value.get<std::int64_t>() >= std::numeric_limits<int>::min();
    if (!fits) return wrong(key, "must be a whole number of 32 bits");
    into = value.get<int>();
  }

  const json& object_;
  std::string place_;
  std::optional<Error>& error_;
};

void read_leg(Fields& fields, std::optional<Leg>& into) {
  std::string word;
  fields.text("leg", word);
  const auto* const found = std::ranges::find(kLegNames, word);
  if (found != kLegNames.end()) into = static_cast<Leg>(found - kLegNames.begin());
  if (!word.empty() && !into) fields.wrong("leg", "must be incoming, contact or rebound");
}

void read_covariance(Fields& fields, std::optional<std::array<double, 4>>& into) {
  const json* value = fields.find("centre_cov_px2");
  if (!value) return;
  std::array<double, 4> c{};
  bool good = value->is_array() && value->size() == 2;
  for (std::size_t row = 0; good && row < 2; ++row) {
    const json& r = (*value)[row];
    good = r.is_array() && r.size() == 2 && r[0].is_number() && r[1].is_number();
    if (good) c[2 * row] = r[0].get<double>(), c[2 * row + 1] = r[1].get<double>();
  }
  if (!good) return fields.wrong("centre_cov_px2", "must be two rows of two numbers");
  into = c;
}

BallImage read_image(const json& object, const std::string& place, std::optional<Error>& error) {
  Fields fields(object, place, error);
  BallImage image;
  fields.number("time_s", image.time_s);
  read_leg(fields, image.leg);
  if (const json* centre = fields.need("centre_px")) fields.point("centre_px", *centre, image.centre_px);
  // A flattened ball may have been given no diameter.
  if (image.leg != Leg::contact || fields.find("diameter_px"))
    fields.number("diameter_px", image.diameter_px);
  fields.number("equator_rad", image.equator_rad);
  fields.number("equator_tilt_rad", image.equator_tilt_rad);
  fields.number("equator_tilt_sd_rad", image.equator_tilt_sd_rad);
  fields.number("equator_tilt_correlation", image.equator_tilt_correlation);
  fields.number("time_sd_s", image.time_sd_s);
  fields.integer("flash_index", image.flash_index);
  read_covariance(fields, image.centre_cov_px2);
  fields.number("diameter_sd_px", image.diameter_sd_px);
  fields.number("equator_sd_rad", image.equator_sd_rad);
  if (const json* top = fields.find("top_px")) fields.point("top_px", *top, image.top_px.emplace());
  fields.number("contact_width_px", image.contact_width_px);
  fields.number("probability", image.probability);
  fields.text("source", image.source);
  return image;
}

void read_surface(Fields& fields, Frame& frame) {
  const json* points = fields.find("surface_px");
  if (!points) return;
  if (!points->is_array() || points->size() == 1) {
    return fields.wrong("surface_px", "must be an array of at least two points, or of none");
  }
  for (std::size_t i = 0; i < points->size(); ++i) {
    fields.point("surface_px[" + std::to_string(i) + "]", (*points)[i], frame.surface_px.emplace_back());
  }
}

void read_lens(Fields& fields, Frame& frame, std::optional<Error>& error) {
  const json* object = fields.find("lens");
  if (!object) return;
  if (!object->is_object()) return fields.wrong("lens", "must be an object");
  Fields of_lens(*object, "lens.", error);
  reduction::Lens& lens = frame.lens.emplace();
  of_lens.number("distance_m", lens.distance_m);
  if (const json* foot = of_lens.need("foot_px")) of_lens.point("foot_px", *foot, lens.foot_px);
}

/// Numbers and truth values of a record are kept as the text they were written as, shortest form.
void read_record(Fields& fields, Frame& frame) {
  const json* record = fields.find("record");
  if (!record) return;
  if (!record->is_object()) return fields.wrong("record", "must be an object");
  for (const auto& [key, value] : record->items()) {
    if (value.is_string())
      frame.record[key] = value.get<std::string>();
    else if (value.is_primitive() && !value.is_null())
      frame.record[key] = json_text(value);
    else if (!value.is_null())
      fields.wrong("record." + key, "must be text or a number");
  }
}

void read_images(Fields& fields, Frame& frame, std::optional<Error>& error) {
  const json* images = fields.need("images");
  if (!images) return;
  if (!images->is_array()) return fields.wrong("images", "must be an array");
  frame.images.reserve(images->size());
  for (std::size_t i = 0; i < images->size() && !error; ++i) {
    const std::string place = "images[" + std::to_string(i) + "]";
    const json& object = (*images)[i];
    if (!object.is_object()) return fields.wrong(place, "must be an object");
    // An image of another leg, which may have no time.
    if (const auto other = object.find("other_leg"); other != object.end() && *other == true) continue;
    frame.images.push_back(read_image(object, place + ".", error));
  }
}

void read_shift(Fields& fields, const std::string& key, const json& value, reduction::MapError& into) {
  const bool numbers = value.is_array() && value.size() == 4 &&
                       std::ranges::all_of(value, [](const json& number) { return number.is_number(); });
  if (!numbers) return fields.wrong(key, "must be four numbers: centre x, y, diameter [px], equator [rad]");
  into.images.push_back(
      {{value[0].get<double>(), value[1].get<double>()}, value[2].get<double>(), value[3].get<double>()});
}

void read_map_error(const json& object, const std::string& place, Frame& frame, std::optional<Error>& error) {
  Fields fields(object, place, error);
  reduction::MapError& into = frame.map_errors.emplace_back();
  const json* images = fields.need("images");
  const json* points = fields.need("surface_px");
  if (!images || !points) return;
  if (!images->is_array()) return fields.wrong("images", "must be an array");
  if (!points->is_array()) return fields.wrong("surface_px", "must be an array");
  for (std::size_t i = 0; i < images->size() && !error; ++i)
    read_shift(fields, "images[" + std::to_string(i) + "]", (*images)[i], into);
  for (std::size_t i = 0; i < points->size() && !error; ++i)
    fields.point("surface_px[" + std::to_string(i) + "]", (*points)[i], into.surface_px.emplace_back());
}

void read_map_errors(Fields& fields, Frame& frame, std::optional<Error>& error) {
  const json* errors = fields.find("map_errors");
  if (!errors) return;
  if (!errors->is_array()) return fields.wrong("map_errors", "must be an array");
  for (std::size_t i = 0; i < errors->size() && !error; ++i) {
    const std::string place = "map_errors[" + std::to_string(i) + "]";
    if (!(*errors)[i].is_object()) return fields.wrong(place, "must be an object");
    read_map_error((*errors)[i], place + ".", frame, error);
  }
}

Frame read_frame(const json& object, std::optional<Error>& error) {
  Frame frame;
  Fields fields(object, "", error);
  fields.integer("shot_id", frame.shot_id);
  fields.number("ball_diameter_m", frame.ball_diameter_m);
  fields.number("ball_diameter_sd_m", frame.ball_diameter_sd_m);
  read_surface(fields, frame);
  fields.number("surface_sd_px", frame.surface_sd_px);
  fields.number("centre_sd_px", frame.centre_sd_px);
  fields.number("diameter_sd_px", frame.diameter_sd_px);
  fields.number("shared_diameter_sd_px", frame.shared_diameter_sd_px);
  fields.number("equator_sd_rad", frame.equator_sd_rad);
  fields.number("px_per_m", frame.px_per_m);
  fields.number("px_per_m_sd", frame.px_per_m_sd);
  read_lens(fields, frame, error);
  std::optional<double> angle;
  fields.number("surface_angle_deg", angle);
  frame.surface_angle_deg = angle.value_or(0.0);
  fields.number("temperature_c", frame.temperature_c);
  fields.number("ball_mass_kg", frame.ball_mass_kg);
  fields.number("ball_alpha", frame.ball_alpha);
  fields.number("ball_alpha_sd", frame.ball_alpha_sd);
  fields.number("fastest_spin_radps", frame.fastest_spin_radps);
  fields.number("air_density_kgpm3", frame.air_density_kgpm3);
  fields.boolean("line_drawn", frame.line_drawn);
  if (const json* object_of_law = fields.find("air_law")) {
    const auto law = air_law_from_json(*object_of_law);
    if (law) frame.air_law = *law;
    if (!law && !error) error = law.error();
  }
  read_record(fields, frame);
  read_map_errors(fields, frame, error);
  read_images(fields, frame, error);
  return frame;
}

ordered_json point(const PointPx& p) { return ordered_json::array({p.x, p.y}); }

template <typename T>
void put(ordered_json& object, const char* key, const std::optional<T>& value) {
  if (!value) return;
  if constexpr (std::is_same_v<T, PointPx>)
    object[key] = point(*value);
  else
    object[key] = *value;
}

ordered_json image_json(const BallImage& image) {
  ordered_json object;
  object["time_s"] = image.time_s;
  if (image.leg) object["leg"] = name(*image.leg);
  object["centre_px"] = point(image.centre_px);
  if (image.leg != Leg::contact || image.diameter_px > 0.0) object["diameter_px"] = image.diameter_px;
  put(object, "equator_rad", image.equator_rad);
  put(object, "equator_tilt_rad", image.equator_tilt_rad);
  put(object, "equator_tilt_sd_rad", image.equator_tilt_sd_rad);
  put(object, "equator_tilt_correlation", image.equator_tilt_correlation);
  put(object, "time_sd_s", image.time_sd_s);
  put(object, "flash_index", image.flash_index);
  if (image.centre_cov_px2) {
    const auto& c = *image.centre_cov_px2;
    object["centre_cov_px2"] = ordered_json::array({{c[0], c[1]}, {c[2], c[3]}});
  }
  put(object, "diameter_sd_px", image.diameter_sd_px);
  put(object, "equator_sd_rad", image.equator_sd_rad);
  put(object, "top_px", image.top_px);
  put(object, "contact_width_px", image.contact_width_px);
  put(object, "probability", image.probability);
  if (!image.source.empty()) object["source"] = image.source;
  if (image.other_leg) object["other_leg"] = true;
  return object;
}

ordered_json map_error_json(const reduction::MapError& error) {
  ordered_json object;
  object["surface_px"] = ordered_json::array();
  for (const PointPx& p : error.surface_px) object["surface_px"].push_back(point(p));
  object["images"] = ordered_json::array();
  for (const auto& s : error.images)
    object["images"].push_back(
        ordered_json::array({s.centre_px.x, s.centre_px.y, s.diameter_px, s.equator_rad}));
  return object;
}

}  // namespace

Result<Frame> frame_from_json(std::string_view text) {
  if (json_depth(text) > kMaxJsonDepth) return fail("nests too deep");
  json document;
  try {
    document = json::parse(text);
  } catch (const json::parse_error& error) {
    return fail("column " + std::to_string(error.byte) + ": is not JSON");
  } catch (const json::exception&) {
    return fail("a number is out of range");
  }
  if (!document.is_object()) return fail("must be a JSON object");
  std::optional<Error> error;
  Frame frame = read_frame(document, error);
  if (error) return tl::unexpected(*error);
  return frame;
}

std::string frame_to_json(const Frame& frame) {
  ordered_json object;
  object["shot_id"] = frame.shot_id;
  object["ball_diameter_m"] = frame.ball_diameter_m;
  put(object, "ball_diameter_sd_m", frame.ball_diameter_sd_m);
  object["surface_px"] = ordered_json::array();
  for (const PointPx& p : frame.surface_px) object["surface_px"].push_back(point(p));
  put(object, "surface_sd_px", frame.surface_sd_px);
  put(object, "centre_sd_px", frame.centre_sd_px);
  put(object, "diameter_sd_px", frame.diameter_sd_px);
  put(object, "shared_diameter_sd_px", frame.shared_diameter_sd_px);
  put(object, "equator_sd_rad", frame.equator_sd_rad);
  put(object, "px_per_m", frame.px_per_m);
  put(object, "px_per_m_sd", frame.px_per_m_sd);
  if (frame.lens)
    object["lens"] = {{"distance_m", frame.lens->distance_m}, {"foot_px", point(frame.lens->foot_px)}};
  for (const reduction::MapError& error : frame.map_errors)
    object["map_errors"].push_back(map_error_json(error));
  object["surface_angle_deg"] = frame.surface_angle_deg;
  put(object, "temperature_c", frame.temperature_c);
  put(object, "ball_mass_kg", frame.ball_mass_kg);
  put(object, "ball_alpha", frame.ball_alpha);
  put(object, "ball_alpha_sd", frame.ball_alpha_sd);
  put(object, "fastest_spin_radps", frame.fastest_spin_radps);
  put(object, "air_density_kgpm3", frame.air_density_kgpm3);
  if (!frame.line_drawn) object["line_drawn"] = false;
  if (frame.air_law) object["air_law"] = air_law_json(*frame.air_law);
  if (!frame.record.empty()) object["record"] = frame.record;
  object["images"] = ordered_json::array();
  for (const BallImage& image : frame.images) object["images"].push_back(image_json(image));
  return json_text(object);
}

}  // namespace strobe::messages
