// Pictures as OpenCV sees them, without a copy: the pixels belong to whoever had them before.
#pragma once

#include <opencv2/core.hpp>

#include "common/image/raster.hpp"

namespace strobe::image {

/// Of 8 or 16 bits. Of three channels: red first.
inline Pixels pixels_of(const cv::Mat& picture) {
  return {picture.data, picture.step,       picture.cols,
          picture.rows, picture.channels(), static_cast<int>(8 * picture.elemSize1())};
}

inline cv::Mat mat_of(Raster& raster) {
  const int type = CV_MAKETYPE(raster.bits() == 8 ? CV_8U : CV_16U, raster.channels());
  return cv::Mat(raster.height(), raster.width(), type, raster.row(0));
}

}  // namespace strobe::image
