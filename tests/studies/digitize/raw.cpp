#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "common/config/files.hpp"
#include "common/image/image_files.hpp"
#include "host/external/program.hpp"
#include "sim/photograph/render.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/studies.hpp"
#include "tests/studies/digitize/tables.hpp"

namespace strobe::studies::digitize {

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

/// The same exposure by a grey sensor, by a colour sensor read as its mosaic, and by that one demosaiced, with a
/// screen's gamma and 8 bits, as a camera's JPEG.
constexpr std::array<const char*, 3> kKinds{"grey", "mosaic", "jpeg"};
constexpr std::size_t kJpeg = 2;
constexpr int kRawNameWidth = 15;
using Scores = std::array<Score, kKinds.size()>;

Result<sim::Photograph> rendered(const Take& take, const sim::SimulatedShot& shot, sim::PhotographFormat format) {
  sim::Scene scene = take.scene;
  scene.photograph.format = format;
  return sim::render(scene, take.seed, shot.exposure);
}

/// By dcraw_emu's AHD, of the DNG file.
Result<Bytes> demosaiced(const sim::Photograph& photograph) {
  const auto program = external::find_program("dcraw_emu");
  if (!program) return fail("dcraw_emu is not installed (Debian package libraw-bin)");
  const auto work = external::WorkFolder::make(fs::temp_directory_path());
  if (!work) return tl::unexpected(work.error());
  const fs::path dng = work->path() / "a.dng";
  if (auto written = sim::write_photograph(dng, photograph.pixels, sim::PhotographFormat::dng, std::nullopt,
                                           photograph.mosaic);
      !written)
    return tl::unexpected(written.error());
  if (auto done = external::run_program({*program, "-W", "-w", "-q", "3", "-T", dng}, *work); !done)
    return tl::unexpected(done.error());
  const auto tiff = config::read_file(dng.string() + ".tiff");
  if (!tiff) return tl::unexpected(tiff.error());
  const auto raster = image::decode_tiff({reinterpret_cast<const unsigned char*>(tiff->data()), tiff->size()});
  if (!raster) return tl::unexpected(raster.error());
  constexpr int kQuality = 95;
  return image::encode_jpeg(raster->pixels(), kQuality);
}

Result<Bytes> bytes_of(const Take& take, const sim::SimulatedShot& shot, std::size_t kind) {
  const auto photograph =
      rendered(take, shot, kind == 0 ? sim::PhotographFormat::tiff : sim::PhotographFormat::mosaic);
  if (!photograph) return tl::unexpected(photograph.error());
  if (kind == kJpeg) return demosaiced(*photograph);
  return image::encode_tiff({photograph->pixels.data, photograph->pixels.step, photograph->pixels.cols,
                             photograph->pixels.rows, 1, 16},
                            {.mosaic = photograph->mosaic});
}

Result<Scores> scores_of(const Take& take, const Options& options) {
  auto known = known_exposure(take);
  if (!known) return tl::unexpected(known.error());
  known->settings.effort = options.effort;
  Scores scores;
  for (std::size_t kind = 0; kind < scores.size(); ++kind) {
    const auto bytes = bytes_of(take, known->shot, kind);
    if (!bytes) return tl::unexpected(bytes.error());
    const auto photograph = strobe::digitize::decode_photograph(*bytes, kKinds[kind]);
    if (!photograph) return tl::unexpected(photograph.error());
    const auto found = strobe::digitize::digitize(*photograph, known->settings);
    if (!found) return tl::unexpected(found.error());
    scores[kind] = score(known->truth, found->frame, reported_places(*found));
    score_surface(known->surface_px, found->frame, scores[kind]);
  }
  return scores;
}

void print_scores(const std::string& name, const Scores& scores) {
  for (std::size_t kind = 0; kind < scores.size(); ++kind)
    print_score(fmt::format("{} {}", name, kKinds[kind]), kRawNameWidth, scores[kind]);
}

}  // namespace

Result<void> study_raw(const Options& options) {
  const auto names = scene_names(options.scenes);
  if (!names) return tl::unexpected(names.error());
  auto scenes = load_scenes(*names);
  if (!scenes) return tl::unexpected(scenes.error());
  for (sim::Scene& scene : *scenes) {
    scene.photograph.bits = sim::kMosaicBits;
    scene.photograph.full_well_e /= options.noise * options.noise;
    scene.photograph.read_noise_e /= options.noise;  // of a well that is so much smaller
  }
  print_score_head(kRawNameWidth);
  const auto shots = static_cast<std::size_t>(options.shots.value_or(1));
  Scores of_scene, all;
  const auto done = try_in_order(
      scenes->size() * shots, options.jobs,
      [&](std::size_t i) {
        return scores_of({(*scenes)[i / shots], options.seed,
                          static_cast<int>(i % shots) + options.first_shot},
                         options);
      },
      [&](std::size_t i, const Scores& scores) {
        for (std::size_t kind = 0; kind < scores.size(); ++kind) of_scene[kind].add(scores[kind]);
        if ((i + 1) % shots != 0) return;
        print_scores((*scenes)[i / shots].name, of_scene);
        for (std::size_t kind = 0; kind < scores.size(); ++kind) all[kind].add(of_scene[kind]);
        of_scene = {};
      });
  if (!done) return done;
  print_scores("all", all);
  for (const std::size_t kind : {std::size_t{1}, kJpeg})
    fmt::print("{}: centres' rms error over that of grey photographs {:.3f}, normalized {:.3f}\n", kKinds[kind],
               centre_rms_px(all[kind]) / centre_rms_px(all[0]), all[kind].mahalanobis.normalized());
  return {};
}

}  // namespace strobe::studies::digitize
