#include "host/commission/camera/measured_pictures.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <utility>

namespace strobe::commission {

void MeasuredPictures::add(const std::filesystem::path& file, const host::RigFile& rig,
                           std::vector<double> flash_times_s) {
  const auto done = std::make_shared<std::promise<void>>();
  std::shared_future<void> before;
  if (!order_.empty()) before = order_.back();
  order_.push_back(done->get_future().share());
  pictures_.push_back(
      std::async(std::launch::async, [file, rig, times = std::move(flash_times_s), before, done] {
        if (before.valid()) before.wait();
        host::MeasureSettings settings;
        settings.flash_times_s = times;
        Picture picture;
        try {
          auto measured = host::measure_photograph(file, rig, settings);
          if (measured)
            picture.measured = std::move(*measured);
          else
            picture.problem = measured.error().message;
        } catch (const std::exception& error) {  // of OpenCV, out of memory
          picture.problem = file.filename().string() + ": " + error.what();
        }
        done->set_value();
        return picture;
      }));
}

bool MeasuredPictures::ready() const {
  return std::ranges::all_of(pictures_, [](const std::future<Picture>& picture) {
    return picture.wait_for(std::chrono::seconds{0}) == std::future_status::ready;
  });
}

std::vector<MeasuredPictures::Picture> MeasuredPictures::take() {
  std::vector<Picture> pictures;
  for (auto& picture : pictures_) pictures.push_back(picture.get());
  pictures_.clear();
  order_.clear();
  return pictures;
}

}  // namespace strobe::commission
