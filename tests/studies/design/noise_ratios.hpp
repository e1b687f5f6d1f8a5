// Errors that were measured on photographs against what host/design predicts of them. Pure; allocates.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "tests/studies/design/noise_photographs.hpp"

namespace strobe::studies::design {

enum class NoiseKind { along, across, diameter, equator, surface };
inline constexpr std::array<std::string_view, 5> kNoiseKindNames{"along", "across", "diameter", "equator",
                                                                 "surface"};

/// Images of one leg (of the photograph: diameter, surface) that were measured and are predicted. Variances
/// are of the mean that the stated variances weigh, times the number of images: what one image contributes.
struct NoiseGroup {
  NoiseKind kind{};
  int images = 0;
  double measured = 0.0;  ///< of each image's own error; no error is taken for more than five stated sds
  double predicted = 0.0;
  double stated = 0.0;
  double common =
      0.0;  ///< square of what all are off alike; may be negative, as the own errors' part is taken off
};

std::vector<NoiseGroup> noise_groups(const NoisePhotograph& photograph);

/// Sums over groups. A group's variance counts for no more than kMaxExcess times what is predicted.
class NoiseRatio {
 public:
  static constexpr double kMaxExcess = 10.0;

  void add(const NoiseGroup& group);
  int images() const { return images_; }
  int groups() const { return groups_; }
  int excessive() const { return excessive_; }  ///< groups beyond kMaxExcess
  double measured() const;                      ///< rms over predicted; NaN without any
  double stated() const;                        ///< likewise
  double common() const;                        ///< likewise; 0 if the squares' sum is below

 private:
  int images_ = 0, groups_ = 0, excessive_ = 0;
  double measured_ = 0.0, stated_ = 0.0, common_ = 0.0;
};

/// How many were measured, and how many are predicted.
struct NoiseCount {
  int of = 0, found = 0;
  double predicted = 0.0;
};

struct NoiseScore {
  std::array<NoiseRatio, kNoiseKindNames.size()> ratios;
  NoiseCount images, equators;       ///< of the equators: those of found images
  int photographs = 0, unknown = 0;  ///< images outside of what is predicted
  int invented = 0;

  void add(const NoisePhotograph& photograph);
};

}  // namespace strobe::studies::design
