#include "sim/ptp/properties.hpp"

namespace strobe::sim::ptp {

namespace {

constexpr std::uint64_t kBulb = 0xFFFFFFFF;
constexpr std::uint64_t kNef = 4;  // compression: what is larger is NEF with a JPEG beside it

std::uint64_t nearest(const std::vector<std::uint64_t>& choices, std::uint64_t value) {
  const auto distance = [value](std::uint64_t choice) {
    return choice > value ? choice - value : value - choice;
  };
  return *std::ranges::min_element(choices, {}, distance);
}

}  // namespace

Properties::Properties() {
  using enum PropertyCode;
  const std::vector<std::uint64_t> on_off{0, 1, 1};
  properties_ = {
      {battery_level, Type::u8, Form::range, false, 90, {1, 100, 1}},
      {compression, Type::u8, Form::enumeration, true, kNef, {0, 1, 2, 4, 5, 6, 7}},
      {f_number, Type::u16, Form::enumeration, true, 800, {280, 400, 560, 800, 1100, 1600}},
      {focus_mode, Type::u16, Form::enumeration, true, 1, {1, 0x8010, 0x8011, 0x8012}},
      {exposure_time, Type::u32, Form::enumeration, true, kBulb, {10, 100, 1000, 10000, kBulb}},
      {exposure_program, Type::u16, Form::enumeration, true, 1, {1, 2, 3, 4}},
      {exposure_index, Type::u16, Form::enumeration, true, 800, {100, 200, 400, 800, 1600, 3200, 6400}},
      {date_time, Type::text, Form::none, true, 0},
      {nikon_monitor_off, Type::u8, Form::enumeration, true, 4, {0, 1, 2, 3, 4}},
      {nikon_long_exposure_noise_reduction, Type::u8, Form::range, true, 0, on_off},
      {nikon_image_review, Type::u8, Form::range, true, 0, on_off},
      {nikon_iso_auto, Type::u8, Form::range, true, 0, on_off},
  };
}

std::vector<std::uint16_t> Properties::codes() const {
  std::vector<std::uint16_t> codes;
  for (const Property& property : properties_) codes.push_back(number(property.code));
  return codes;
}

void Properties::write_value(DatasetWriter& writer, const Property& property, std::uint64_t value) {
  switch (property.type) {
    case Type::u8:
      writer.u8(value);
      break;
    case Type::u16:
      writer.u16(value);
      break;
    case Type::u32:
      writer.u32(value);
      break;
    case Type::text:
      writer.text(property.text);
      break;
  }
}

Answer Properties::description(std::uint16_t code) const {
  const auto property = find(properties_, code);
  if (property == properties_.end()) return {Response::property_not_supported, {}, {}};
  DatasetWriter writer;
  writer.u16(code).u16(number(property->type)).u8(property->writable ? 1 : 0);
  write_value(writer, *property, property->value);  // by the factory
  write_value(writer, *property, property->value);
  writer.u8(static_cast<std::uint8_t>(property->form));
  if (property->form == Form::enumeration) writer.u16(property->choices.size());
  for (const std::uint64_t choice : property->choices) write_value(writer, *property, choice);
  return {Response::ok, {}, writer.take()};
}

Answer Properties::value(std::uint16_t code) const {
  const auto property = find(properties_, code);
  if (property == properties_.end()) return {Response::property_not_supported, {}, {}};
  DatasetWriter writer;
  write_value(writer, *property, property->value);
  return {Response::ok, {}, writer.take()};
}

bool Properties::holds(const Property& property, std::uint64_t value) {
  if (property.form == Form::range) return value >= property.choices[0] && value <= property.choices[1];
  return std::ranges::find(property.choices, value) != property.choices.end();
}

Response Properties::set(std::uint16_t code, std::span<const std::uint8_t> data) {
  const auto property = find(properties_, code);
  if (property == properties_.end()) return Response::property_not_supported;
  if (!property->writable) return Response::access_denied;
  DatasetReader reader(data);
  if (property->type == Type::text) {
    property->text = reader.text();
    return reader.complete() ? Response::ok : Response::invalid_property_format;
  }
  std::uint64_t value = property->type == Type::u8    ? reader.u8()
                        : property->type == Type::u16 ? reader.u16()
                                                      : reader.u32();
  if (!reader.complete()) return Response::invalid_property_format;
  if (property->code == PropertyCode::exposure_index) value = nearest(property->choices, value);
  if (!holds(*property, value)) return Response::invalid_property_value;
  property->value = value;
  return Response::ok;
}

std::uint64_t Properties::get(PropertyCode code) const { return find(properties_, number(code))->value; }

void Properties::put(PropertyCode code, std::uint64_t value) {
  find(properties_, number(code))->value = value;
}

void Properties::set_clock(std::string text) {
  find(properties_, number(PropertyCode::date_time))->text = std::move(text);
}

FilesWritten Properties::files_written() const {
  const std::uint64_t compression = get(PropertyCode::compression);
  return {compression >= kNef, compression != kNef};
}

}  // namespace strobe::sim::ptp
