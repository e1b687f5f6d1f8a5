#include "tests/real/finders.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::real {

namespace {

using nlohmann::json;

std::string quoted(const std::string& word) {
  std::string result = "'";
  for (const char c : word) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string with_values(const std::string& command, const Question& question) {
  const std::pair<std::string, std::string> values[] = {
      {"{file}", quoted(question.file.string())},
      {"{ball_diameter_m}", fmt::format("{}", question.ball_diameter_m)},
      {"{px_per_m}", fmt::format("{}", question.px_per_m)},
      {"{size_tolerance}", fmt::format("{}", question.tolerance_percent)}};
  std::string result;
  for (std::size_t at = 0; at < command.size();) {
    const auto value = std::ranges::find_if(
        values, [&](const auto& each) { return command.compare(at, each.first.size(), each.first) == 0; });
    const bool is_value = value != std::end(values);
    result += is_value ? value->second : std::string(1, command[at]);
    at += is_value ? value->first.size() : 1;
  }
  return result;
}

std::string last_line(std::string text) {
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.empty() ? "no message" : text.substr(text.find_last_of('\n') + 1);
}

Result<Answer> ask(const std::string& command, const Question& question) {
  const auto done = testing::run_process({.arguments = {"/bin/sh", "-c", with_values(command, question)}},
                                         std::chrono::minutes(5));
  const std::string name = question.file.filename().string();
  if (!done.status) return fail(name + ": the program takes longer than five minutes");
  if (done.status->signal != 0 || done.status->code < 0 || done.status->code > 1)
    return fail(fmt::format(
        "{}: the program ends with {} {}: {}", name, done.status->signal != 0 ? "signal" : "exit status",
        done.status->signal != 0 ? done.status->signal : done.status->code, last_line(done.err)));
  auto answer = parse_answer(done.out, question.pixels.rows, question.told_px());
  if (!answer)
    return fail(fmt::format("{}: the program's answer: {}; it says: {}", name, answer.error().message,
                            last_line(done.err)));
  return answer;
}

/// NaN if it is none.
double number_at(const json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found != object.end() && found->is_number() ? found->get<double>() : NAN;
}

/// Nothing where one of them is not stated.
std::optional<Found::Sds> sds_of(double x, double y, double d) {
  return x > 0.0 && y > 0.0 && d > 0.0 ? std::optional<Found::Sds>({x, y, d}) : std::nullopt;
}

/// Of a frame's image. NaN if it is not stated.
double centre_sd_at(const json& image, std::size_t axis) {
  const auto found = image.find("centre_cov_px2");
  const bool is_matrix = found != image.end() && found->is_array() && found->size() == 2 &&
                         (*found)[axis].is_array() && (*found)[axis].size() == 2;
  return is_matrix && (*found)[axis][axis].is_number() ? std::sqrt((*found)[axis][axis].get<double>()) : NAN;
}

/// Of a frame, whose y goes upwards. NaN if it is none.
Point centre_at(const json& object, int height) {
  const json pair = object.is_object() ? object.value("centre_px", json()) : json();
  if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number() || !pair[1].is_number()) return {NAN, NAN};
  return {pair[0].get<double>(), height - 1 - pair[1].get<double>()};
}

Result<Answer> answer_of_frame(const json& frame, int height, double told_px) {
  Answer answer;
  for (const json& image : frame.value("images", json::array())) {
    const Point at = centre_at(image, height);
    if (!std::isfinite(at.x + at.y)) return fail("an image has no centre_px");
    const double d = number_at(image, "diameter_px");
    answer.circles.push_back(
        {{at.x, at.y, d > 0.0 ? d : told_px},
         sds_of(centre_sd_at(image, 0), centre_sd_at(image, 1), number_at(image, "diameter_sd_px"))});
  }
  for (const json& place : frame.value("unmeasured", json::array())) {
    if (messages::value_of<std::string>(place, "what") != "image") continue;
    const auto word = [&](const char* key) { return messages::value_of<std::string>(place, key); };
    answer.refusals.push_back({centre_at(place, height), word("reason") + ": " + word("detail")});
  }
  return answer;
}

Result<Answer> answer_of_circles(const json& circles) {
  if (!circles.is_array()) return fail("neither circles nor a frame");
  Answer answer;
  for (const json& each : circles) {
    const Circle circle{number_at(each, "x"), number_at(each, "y"), number_at(each, "d")};
    if (!std::isfinite(circle.x + circle.y + circle.d) || circle.d <= 0.0)
      return fail(fmt::format("circle {} lacks x, y or a d above 0", answer.circles.size() + 1));
    answer.circles.push_back(
        {circle, sds_of(number_at(each, "x_sd"), number_at(each, "y_sd"), number_at(each, "d_sd"))});
  }
  return answer;
}

cv::Mat grey_of(const cv::Mat& pixels) {
  cv::Mat grey = pixels;
  if (pixels.channels() == 3) cv::cvtColor(pixels, grey, cv::COLOR_RGB2GRAY);
  if (grey.depth() != CV_8U) grey.convertTo(grey, CV_8U, 255.0 / 65535.0);
  return grey;
}

struct Hough {
  int method;
  double dp, canny, strength;
  int blur;  ///< side of the median filter, px
};

Answer circles_by(const Hough& hough, const Question& question) {
  cv::Mat grey;
  cv::medianBlur(grey_of(question.pixels), grey, hough.blur);
  const double r = 0.5 * question.told_px(), off = 0.01 * question.tolerance_percent;
  std::vector<cv::Vec3f> circles;
  cv::HoughCircles(grey, circles, hough.method, hough.dp, 0.6 * r, hough.canny, hough.strength,
                   static_cast<int>(r * (1.0 - off)), static_cast<int>(std::ceil(r * (1.0 + off))));
  Answer answer;
  for (const auto& c : circles) answer.circles.push_back({{c[0], c[1], 2.0 * c[2]}});
  return answer;
}

struct Blob {
  float round, convex, step;
};

Answer circles_by(const Blob& blob, const Question& question) {
  const double d = question.told_px(), off = 0.01 * question.tolerance_percent;
  const auto area = [d](double part) { return static_cast<float>(CV_PI / 4.0 * d * d * part * part); };
  cv::SimpleBlobDetector::Params p;
  p.minThreshold = 10, p.maxThreshold = 250, p.thresholdStep = blob.step;
  p.minDistBetweenBlobs = static_cast<float>(0.3 * d);
  p.filterByColor = true, p.blobColor = 255;
  p.filterByArea = true, p.minArea = area(1.0 - off), p.maxArea = area(1.0 + off);
  p.filterByCircularity = true, p.minCircularity = blob.round;
  p.filterByConvexity = true, p.minConvexity = blob.convex;
  p.filterByInertia = false;
  std::vector<cv::KeyPoint> points;
  cv::SimpleBlobDetector::create(p)->detect(grey_of(question.pixels), points);
  Answer answer;
  for (const auto& point : points) answer.circles.push_back({{point.pt.x, point.pt.y, point.size}});
  return answer;
}

template <typename Setting>
NamedFinder named(std::string name, const Setting& setting) {
  return {std::move(name),
          [setting](const Question& question) -> Result<Answer> { return circles_by(setting, question); }};
}

}  // namespace

Finder finder_of(const std::string& command) {
  return [command](const Question& question) { return ask(command, question); };
}

std::string digitize_command(const std::filesystem::path& strobe) {
  return quoted(strobe.string()) +
         " digitize {file} --ball-diameter-m {ball_diameter_m} --px-per-m {px_per_m}"
         " --size-tolerance {size_tolerance} --json --explain";
}

Result<Answer> parse_answer(std::string_view text, int height, double told_px) {
  auto answer = messages::parsed_json<json>(text);
  if (answer.is_discarded()) answer = messages::parsed_json<json>(text.substr(0, text.find('\n')));
  if (answer.is_discarded()) return fail("is not JSON");
  if (answer.is_object() && answer.contains("circles")) return answer_of_circles(answer["circles"]);
  if (answer.is_object() && answer.contains("images")) {
    if (!answer["images"].is_array()) return fail("images is no list");
    return answer_of_frame(answer, height, told_px);
  }
  return answer_of_circles(answer);
}

std::vector<NamedFinder> hough_finders() {
  std::vector<NamedFinder> all;
  for (const int blur : {3, 5}) {
    for (const double strength : {30.0, 40.0, 50.0, 60.0})
      all.push_back(named(fmt::format("HoughCircles, gradient, strength {}, median {}", strength, blur),
                          Hough{cv::HOUGH_GRADIENT, 1.0, 100.0, strength, blur}));
    for (const double round : {0.5, 0.65, 0.8})
      all.push_back(named(fmt::format("HoughCircles, gradient-alt, roundness {}, median {}", round, blur),
                          Hough{cv::HOUGH_GRADIENT_ALT, 1.5, 200.0, round, blur}));
  }
  return all;
}

std::vector<NamedFinder> blob_finders() {
  std::vector<NamedFinder> all;
  for (const float step : {5.0F, 10.0F})
    for (const float round : {0.5F, 0.65F, 0.8F})
      for (const float convex : {0.8F, 0.9F})
        all.push_back(named(
            fmt::format("SimpleBlobDetector, step {}, circularity {}, convexity {}", step, round, convex),
            Blob{round, convex, step}));
  return all;
}

}  // namespace strobe::real
