// How far each pixel of one row is covered by spans of it: the inside of pixels.hpp. Not thread-safe; keeps
// its buffer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace strobe::sim {

/// A row's coverage by spans, as differences along it; x = 0 is the left side of the row's first pixel.
class RowCoverage {
 public:
  void clear(std::size_t width) {
    differences_.assign(width + 2, 0.0);
    rises_ = falls_ = {width + 2, 0};
  }
  void add(double from, double to, double weight) {
    if (to <= from) return;
    note(from, weight, rises_);
    note(to, -weight, falls_);
  }
  bool empty() const { return first() >= end(); }
  /// Pixels from the first that a span begins in to behind the last that one ends in.
  std::size_t first() const { return std::min(rises_.first, falls_.first); }
  std::size_t end() const { return std::max(rises_.end, falls_.end); }
  /// Where coverage is even: all spans have begun, none has ended.
  std::size_t even_first() const { return rises_.end; }
  std::size_t even_end() const { return falls_.first; }
  double step(std::size_t pixel) const { return differences_[pixel]; }

 private:
  struct Range {
    std::size_t first = 0;
    std::size_t end = 0;
  };

  void note(double x, double weight, Range& range) {
    const double pixel = std::floor(x);
    const auto i = static_cast<std::size_t>(pixel);
    differences_[i] += weight * (pixel + 1.0 - x);
    differences_[i + 1] += weight * (x - pixel);
    range.first = std::min(range.first, i);
    range.end = std::max(range.end, i + 2);
  }

  std::vector<double> differences_;  ///< two more than the row is wide
  Range rises_;
  Range falls_;
};

}  // namespace strobe::sim
