#include "host/drivers/gphoto2/config_tree.hpp"

#include <fmt/format.h>
#include <gphoto2/gphoto2-widget.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <memory>

namespace strobe::gphoto2 {

namespace {

struct FreeWidget {
  void operator()(CameraWidget* widget) const { gp_widget_free(widget); }
};
using Widget = std::unique_ptr<CameraWidget, FreeWidget>;

std::string text_of(CameraWidget* widget, CameraWidgetType type) {
  const char* text = nullptr;
  int number = 0;
  float real = 0.0F;
  switch (type) {
    case GP_WIDGET_TEXT:
    case GP_WIDGET_RADIO:
    case GP_WIDGET_MENU:
      gp_widget_get_value(widget, &text);
      return text == nullptr ? "" : text;
    case GP_WIDGET_TOGGLE:
    case GP_WIDGET_DATE:
      gp_widget_get_value(widget, &number);
      return fmt::format("{}", number);
    case GP_WIDGET_RANGE:
      gp_widget_get_value(widget, &real);
      return fmt::format("{}", real);
    default:
      return "";
  }
}

void collect(CameraWidget* widget, Config& config) {
  CameraWidgetType type = GP_WIDGET_WINDOW;
  gp_widget_get_type(widget, &type);
  if (type == GP_WIDGET_WINDOW || type == GP_WIDGET_SECTION) {
    for (int i = 0; i < gp_widget_count_children(widget); ++i) {
      CameraWidget* child = nullptr;
      if (gp_widget_get_child(widget, i, &child) >= GP_OK) collect(child, config);
    }
    return;
  }
  const char* name = nullptr;
  if (type == GP_WIDGET_BUTTON || gp_widget_get_name(widget, &name) < GP_OK || name == nullptr) return;
  ConfigValue value;
  value.value = text_of(widget, type);
  const bool chosen = type == GP_WIDGET_RADIO || type == GP_WIDGET_MENU;
  for (int i = 0; chosen && i < gp_widget_count_choices(widget); ++i) {
    const char* choice = nullptr;
    if (gp_widget_get_choice(widget, i, &choice) >= GP_OK) value.choices.emplace_back(choice);
  }
  int read_only = 0;
  gp_widget_get_readonly(widget, &read_only);
  value.read_only = read_only != 0;
  config.emplace(name, std::move(value));
}

/// Fails for a text that is no number where one is needed.
int put(CameraWidget* widget, CameraWidgetType type, const std::string& value) {
  char* end = nullptr;
  if (type == GP_WIDGET_TOGGLE || type == GP_WIDGET_DATE) {
    const int number = static_cast<int>(std::strtol(value.c_str(), &end, 10));
    return value.empty() || *end != '\0' ? GP_ERROR_BAD_PARAMETERS : gp_widget_set_value(widget, &number);
  }
  if (type == GP_WIDGET_RANGE) {
    const float number = std::strtof(value.c_str(), &end);
    return value.empty() || *end != '\0' ? GP_ERROR_BAD_PARAMETERS : gp_widget_set_value(widget, &number);
  }
  return gp_widget_set_value(widget, value.c_str());
}

}  // namespace

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

Result<Config> read_config(Camera* camera, GPContext* context) {
  CameraWidget* root = nullptr;
  const int result = gp_camera_get_config(camera, &root, context);
  if (result == GP_ERROR_NOT_SUPPORTED) return Config{};
  if (result < GP_OK) return fail(gp_result_as_string(result));
  const Widget owned(root);
  Config config;
  collect(root, config);
  return config;
}

Result<void> set_config(Camera* camera, GPContext* context, const std::string& name,
                        const std::string& value) {
  CameraWidget* found = nullptr;
  int result = gp_camera_get_single_config(camera, name.c_str(), &found, context);
  if (result < GP_OK) return fail(gp_result_as_string(result));
  const Widget owned(found);
  CameraWidgetType type = GP_WIDGET_TEXT;
  gp_widget_get_type(found, &type);
  result = put(found, type, value);
  if (result >= GP_OK) result = gp_camera_set_single_config(camera, name.c_str(), found, context);
  if (result < GP_OK) return fail(gp_result_as_string(result));
  return {};
}

}  // namespace strobe::gphoto2
