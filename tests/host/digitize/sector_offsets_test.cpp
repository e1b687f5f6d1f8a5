// Which sectors of an outline share the terminator's error.
#include "host/digitize/outline/sector_offsets.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::digitize;

constexpr int kSectors = 80;
constexpr double kSigma_px = 1.2;

/// Dark over `dark` sectors; from both ends of them on the limb's step grows by a tenth a sector, up to 1, and what
/// its curvature adds is a quarter of a full step.
SectorOffsets outline(int dark) {
  SectorOffsets offsets;
  offsets.edges.resize(kSectors);
  for (int i = 0; i < kSectors; ++i) {
    SectorEdge& edge = offsets.edges[static_cast<std::size_t>(i)];
    edge.no_edge = i < dark;
    edge.usable = !edge.no_edge;
    edge.sd_px = 0.05;
    const int from_end = std::min(i - dark + 1, kSectors - i);
    edge.step = edge.no_edge ? 0.0 : std::min(1.0, 0.1 * from_end);
    edge.rounding = edge.no_edge ? 0.0 : 0.25 * (1.0 - edge.step) + 0.02;
  }
  downweight_shadow(offsets, kSigma_px);
  return offsets;
}

double common(const SectorOffsets& offsets, int sector) {
  return offsets.common_sd[static_cast<std::size_t>(sector)];
}

}  // namespace

TEST_GROUP(SectorOffsets){};

TEST(SectorOffsets, OfAHalfLitBallShareAnErrorAsFarAsLightIsOblique) {
  const SectorOffsets offsets = outline(40);
  CHECK_TRUE(offsets.half_lit);
  // Next to the terminator the curvature adds more than the step.
  CHECK_COMPARE(common(offsets, 40), >, 0.3 * kSigma_px);
  // Beyond the reach of single edges, with a step twice the rounding's.
  CHECK_COMPARE(common(offsets, 45), >, kSigma_px / 8.0);
  DOUBLES_EQUAL(common(offsets, 45), common(offsets, 80 - 6), 1e-12);
  // Where the step is eight times the rounding it is as clear as anywhere.
  DOUBLES_EQUAL(0.0, common(offsets, 60), 0.0);
  for (int i = 41; i < 60; ++i) CHECK_COMPARE(common(offsets, i), <=, common(offsets, i - 1) + 1e-12);
}

TEST(SectorOffsets, OfAShortShadowShareAnErrorBesideItOnly) {
  const SectorOffsets offsets = outline(8);
  CHECK_FALSE(offsets.half_lit);
  CHECK_COMPARE(common(offsets, 8), >, 0.0);
  DOUBLES_EQUAL(0.0, common(offsets, 8 + 6), 0.0);
  DOUBLES_EQUAL(0.0, common(offsets, 44), 0.0);
}

TEST(SectorOffsets, CountTheSharedErrorAsVarianceOfEach) {
  SectorOffsets offsets = outline(40);
  offsets.weight.resize(kSectors);
  offsets.robust = offsets.sensitivity = offsets.weight;
  const std::vector<double> residuals(kSectors, 0.0);
  reweight(offsets, residuals);
  const double at_terminator = offsets.weight[40], clear = offsets.weight[60];
  const double expected = (0.05 * 0.05 + std::pow(common(offsets, 40), 2)) / (0.05 * 0.05);
  // The variance that residuals show is at its least, 1e-6 px².
  DOUBLES_EQUAL(expected, clear / at_terminator, 1e-3 * expected);
  DOUBLES_EQUAL(0.0, offsets.weight[20], 0.0);
}
