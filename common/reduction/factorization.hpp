// Orthogonal factorization for the joint fit: rows are reflected to a triangle, and the triangle is kept in
// the blocks that the elimination leaves. Part of the reduction, not of its interface. Fixed size, no
// allocation; thread-safe as plain values.
// Source: Golub, Van Loan, Matrix Computations, 4th ed., 5.2.2 (Householder QR), 6.5 (appending rows).
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace strobe::reduction {

/// Takes the rows of a matrix (the right side is its last column) and keeps the upper triangle of its first
/// `Pivots` columns. What the reflections leave of the other columns is handed on, row by row, so that the
/// unknowns that a group of measurements has to itself are eliminated before those that groups share. Kept
/// because Eigen's HouseholderQR of a leg's ten rows takes 1.9 times the instructions (5,600 against 2,900).
template <int Pivots, int Columns>
class HouseholderQr {
 public:
  static constexpr int kRows = 16;  ///< reflected together
  using Row = std::array<double, Columns>;
  using Rest = std::array<double, Columns - Pivots>;

  /// `next` is called with a Rest for every row left over.
  template <typename Next>
  void add(const Row& row, Next&& next) {
    if (count_ == kRows) reflect(next);
    assert(count_ < kRows);
    for (int c = 0; c < Columns; ++c) at(c, count_) = row[static_cast<std::size_t>(c)];
    ++count_;
  }

  /// To be called after the last row.
  template <typename Next>
  void reflect(Next&& next) {
    for (int k = 0; k < Pivots && k < count_; ++k) reflect_column(k);
    for (int r = Pivots; r < count_; ++r) {
      Rest rest;
      for (int c = Pivots; c < Columns; ++c) rest[static_cast<std::size_t>(c - Pivots)] = at(c, r);
      next(rest);
    }
    if (count_ > Pivots) count_ = Pivots;
  }

  /// Row `row` < Pivots of the triangle and of what stands beside it; zero below the diagonal.
  double triangle(int row, int column) const {
    return row < count_ ? columns_[static_cast<std::size_t>(column)][static_cast<std::size_t>(row)] : 0.0;
  }

 private:
  double& at(int column, int row) {
    return columns_[static_cast<std::size_t>(column)][static_cast<std::size_t>(row)];
  }

  static double dot(const double* a, const double* b, int count) {
    double even = 0.0;
    double odd = 0.0;
    int i = 0;
    for (; i + 1 < count; i += 2) {
      even += a[i] * b[i];
      odd += a[i + 1] * b[i + 1];
    }
    if (i < count) even += a[i] * b[i];
    return even + odd;
  }

  /// v = column less its image beta e1; H = I - v v^T / (|beta| |v_1|).
  void reflect_column(int k) {
    const int count = count_ - k;
    double* v = &at(k, k);
    const double norm = std::sqrt(dot(v, v, count));
    if (!(norm > 0.0)) return;
    const double beta = std::copysign(norm, -v[0]);
    v[0] -= beta;
    const double scale = 1.0 / (norm * std::abs(v[0]));
    for (int c = k + 1; c < Columns; ++c) {
      double* other = &at(c, k);
      const double share = scale * dot(v, other, count);
      for (int i = 0; i < count; ++i) other[i] -= share * v[i];
    }
    v[0] = beta;
    for (int i = 1; i < count; ++i) v[i] = 0.0;
  }

  std::array<std::array<double, kRows>, Columns> columns_;
  int count_ = 0;
};

/// Unknowns: tilt [rad], height [m] and scale (about 1) against the surface frame, then for each leg the
/// position and the velocity in the levelled photograph, at the leg's mean time, in metres and metres per
/// span. The equator's angle and spin of each leg, the other four of the fifteen, share no measurement with
/// these.
inline constexpr std::size_t kTilt = 0;
inline constexpr std::size_t kHeight = 1;
inline constexpr std::size_t kScale = 2;
inline constexpr std::size_t kLegStart[2] = {3, 7};  // x, y, vx * span, vy * span
inline constexpr std::size_t kJointCount = 11;

using JointVector = std::array<double, kJointCount>;

/// Of whitened gradients: their numbers' covariance.
template <std::size_t N>
double dot(const std::array<double, N>& a, const std::array<double, N>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
  return sum;
}

/// Square-root information matrix of the joint fit: the upper triangular R of its whitened measurements, with
/// R^T R = inverse covariance: each leg's own four unknowns, what couples them to tilt and scale, and the
/// three that all share. An unknown without measurements has a zero row: no variance, no change. Eigen's
/// triangular solvers would divide by that zero, and sum in another order: readouts would change in their
/// last digits.
struct SquareRootInformation {
  struct Leg {
    double r[4][4] = {};         ///< upper triangle
    double coupling[4][2] = {};  ///< columns: tilt, scale
  };
  Leg leg[2];
  double r[3][3] = {};  ///< upper triangle of tilt, height, scale

  /// R^-T g: the dot product of two such is the covariance of two numbers with gradients g.
  JointVector whitened(const JointVector& gradient) const;

  /// The same for a gradient by one leg's unknowns and by tilt and scale alone, as its images have:
  /// leg (4), tilt, height, scale.
  std::array<double, 7> whitened(std::size_t leg, const std::array<double, 6>& gradient) const;

  /// The same for a gradient by tilt, height and scale alone; the first four are zero.
  std::array<double, 7> shared(double by_tilt, double by_height, double by_scale) const;

  /// R^-1 y.
  JointVector unknowns(const JointVector& y) const;
};

}  // namespace strobe::reduction
