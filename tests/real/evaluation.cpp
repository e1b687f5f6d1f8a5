#include "tests/real/evaluation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <thread>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::real {

namespace {

/// What the alterations can crop and turn.
constexpr int kSmallestSide_px = 64;

Result<cv::Mat> read_pixels(const Photograph& photograph) {
  const std::string name = photograph.path.string();
  std::ifstream stream(photograph.path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.is_open() || stream.bad()) return fail(name + ": cannot be read");
  auto raster = image::decode({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  if (!raster) return fail(name + ": " + raster.error().message);
  if (raster->mosaic) return fail(name + ": a colour sensor's mosaic cannot be altered; convert it first");
  if (std::min(raster->width(), raster->height()) < kSmallestSide_px)
    return fail(fmt::format("{}: has a side of less than {} px", name, kSmallestSide_px));
  return image::mat_of(*raster).clone();
}

Result<void> write_pixels(const std::filesystem::path& path, const cv::Mat& pixels) {
  const auto bytes = image::encode_png(image::pixels_of(pixels));
  if (!bytes) return tl::unexpected(bytes.error());
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
  stream.close();
  if (!stream) return fail(path.string() + ": cannot be written");
  return {};
}

std::string said_of(const Ball& ball, const Answer& answer) {
  const Refusal* nearest = nullptr;
  double least = kReach * ball.d;
  for (const Refusal& refusal : answer.refusals)
    if (const double off = std::hypot(refusal.at.x - ball.x, refusal.at.y - ball.y); off <= least)
      least = off, nearest = &refusal;
  return nearest ? nearest->why : "nothing was said of this place";
}

/// One photograph, altered in one way, at each scale.
Result<std::vector<Outcome>> outcomes_of(const Photograph& photograph, const Alteration& alteration,
                                         const Finder& finder, const Asked& asked,
                                         const std::filesystem::path& file) {
  if ((photograph.curved || photograph.bounces) && !alteration.keeps_gravity) return std::vector<Outcome>{};
  const auto pixels = read_pixels(photograph);
  if (!pixels) return tl::unexpected(pixels.error());
  const Altered altered = alteration.make(*pixels);
  const Photograph truth = altered_truth(photograph, altered, pixels->size());
  const bool is_altered = &alteration != &alterations().front();
  if (is_altered)
    if (auto done = write_pixels(file, altered.pixels); !done) return tl::unexpected(done.error());
  std::vector<Outcome> outcomes;
  for (const double told : asked.told) {
    const auto answer =
        finder({is_altered ? file : std::filesystem::absolute(photograph.path), altered.pixels,
                truth.ball_diameter_m, told * truth.px_per_m, asked.tolerance_percent});
    if (!answer)
      return fail(fmt::format("{}, {}: {}", photograph.file, alteration.name, answer.error().message));
    // A ball at the tolerance's edge is a matter of the annotation: a percent less than is told.
    const double tolerance = told == 1.0 ? 1e9 : 0.01 * (asked.tolerance_percent - 1.0);
    Outcome outcome{
        &photograph, &alteration, told, judged(truth, answer->circles, told, tolerance, altered.scale), {}};
    for (const Ball& ball : outcome.score.missed) outcome.why.push_back(said_of(ball, *answer));
    outcomes.push_back(std::move(outcome));
  }
  if (is_altered) std::filesystem::remove(file);
  return outcomes;
}

}  // namespace

Result<std::vector<Outcome>> evaluated(const std::vector<Photograph>& photographs, const Finder& finder,
                                       const Asked& asked,
                                       const std::function<void(std::size_t, std::size_t)>& progress) {
  const testing::TemporaryFolder folder;
  const std::size_t count = asked.alterations.size() * photographs.size();
  std::vector<std::vector<Outcome>> each(count);
  std::optional<Error> error;
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  const auto is_stopped = [&asked] { return asked.stopped != nullptr && *asked.stopped; };
  const auto work = [&] {
    for (std::size_t i = next++; i < count && !is_stopped(); i = next++) {
      Result<std::vector<Outcome>> outcomes;
      try {
        outcomes =
            outcomes_of(photographs[i % photographs.size()], *asked.alterations[i / photographs.size()],
                        finder, asked, folder / fmt::format("altered-{}.png", i));
      } catch (const std::exception& thrown) {  // OpenCV's, and processes that cannot be started
        outcomes = fail(photographs[i % photographs.size()].file + ": " + thrown.what());
      }
      const std::lock_guard lock(mutex);
      if (!outcomes) {
        if (!error) error = outcomes.error();
        next = count;
        return;
      }
      each[i] = std::move(*outcomes);
      if (progress) progress(++done, count);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < asked.jobs; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (is_stopped()) return fail("stopped");
  if (error) return tl::unexpected(*error);
  std::vector<Outcome> all;
  for (auto& outcomes : each)
    all.insert(all.end(), std::make_move_iterator(outcomes.begin()), std::make_move_iterator(outcomes.end()));
  return all;
}

Score total(const std::vector<Outcome>& outcomes, const Alteration* alteration, double told) {
  Score sum;
  for (const Outcome& outcome : outcomes)
    if ((alteration == nullptr || outcome.alteration == alteration) && outcome.told == told)
      sum += outcome.score;
  return sum;
}

Result<NamedFinder> best_of(const std::vector<NamedFinder>& finders,
                            const std::vector<Photograph>& photographs, const Asked& asked) {
  const Asked as_they_are{
      {&alterations().front()}, {1.0}, asked.tolerance_percent, asked.jobs, asked.stopped};
  const NamedFinder* best = nullptr;
  double most = -1.0;
  for (const NamedFinder& finder : finders) {
    const auto outcomes = evaluated(photographs, finder.find, as_they_are);
    if (!outcomes) return tl::unexpected(outcomes.error());
    if (const double f1 = total(*outcomes, nullptr).f1(); f1 > most) most = f1, best = &finder;
  }
  return *best;
}

}  // namespace strobe::real
