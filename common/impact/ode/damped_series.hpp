// The two solutions of v'' + 2b·v' + f·v = 0, whichever its damping, at several times at once: S with S(0) = 0, S'(0) =
// 1; its rate V = S'; W = V + 2b·S has W(0) = 1, W'(0) = 0. Taylor's series of the time halved until 0.8 of the fastest
// decay or turn remains, then doubled as often. Without a branch or a library's function in its loops: compilers
// take several times in one instruction, and all give the same bits. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace strobe::impact::detail {

/// `terms` of the series: the first left out is 0.8^terms/terms! of the first, and counts twice per doubling.
template <std::size_t terms>
class DampedSeries {
 public:
  DampedSeries(double b, double f) : b_(b), f_(f) {
    const double b2 = b * b;
    fastest_ = b2 > f ? b + std::sqrt(b2 - f) : std::sqrt(f);
    v_[0] = 1.0;
    v_[1] = -2.0 * b;
    for (std::size_t k = 2; k < terms; ++k)
      v_[k] = -(2.0 * b * kInverse.of[k] * v_[k - 1] + f * kInverse.of[k] * kInverse.of[k - 1] * v_[k - 2]);
    for (std::size_t k = 0; k < terms; ++k) s_[k] = v_[k] * kInverse.of[k + 1];
  }

  /// `longest`: of the times.
  template <std::size_t n>
  void along(const std::array<double, n>& times, double longest, std::array<double, n>& sine,
             std::array<double, n>& rate) const {
    double part = 1.0;
    const int halvings = halve(fastest_ * longest, part);
    for (std::size_t i = 0; i < n; ++i) {
      const double t = part * times[i];
      double s = s_[terms - 1], v = v_[terms - 1];
      for (std::size_t k = terms - 1; k-- > 0;) {
        s = s_[k] + s * t;
        v = v_[k] + v * t;
      }
      sine[i] = s * t;
      rate[i] = v;
    }
    for (int k = 0; k < halvings; ++k) {
      for (std::size_t i = 0; i < n; ++i) {
        const double s = sine[i], v = rate[i];
        sine[i] = 2.0 * s * (v + b_ * s);
        rate[i] = v * v - f_ * (s * s);
      }
    }
  }

  /// exp(speed·t), by the same means.
  template <std::size_t n>
  static void exponentials(double speed, const std::array<double, n>& times, double longest,
                           std::array<double, n>& out) {
    double part = speed;
    const int halvings = halve(std::abs(speed) * longest, part);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = part * times[i];
      double e = kFactorials.inverse[terms - 1];
      for (std::size_t k = terms - 1; k-- > 0;) e = kFactorials.inverse[k] + e * x;
      out[i] = e;
    }
    for (int k = 0; k < halvings; ++k)
      for (std::size_t i = 0; i < n; ++i) out[i] *= out[i];
  }

 private:
  struct Inverse {
    std::array<double, terms + 1> of{};
    constexpr Inverse() {
      for (std::size_t k = 1; k <= terms; ++k) of[k] = 1.0 / static_cast<double>(k);
    }
  };
  struct Factorials {
    std::array<double, terms> inverse{};
    constexpr Factorials() {
      double factorial = 1.0;
      for (std::size_t k = 0; k < terms; ++k) {
        if (k > 0) factorial *= static_cast<double>(k);
        inverse[k] = 1.0 / factorial;
      }
    }
  };
  static constexpr Inverse kInverse{};
  static constexpr Factorials kFactorials{};

  static int halve(double phase, double& part) {
    int halvings = 0;
    for (; phase > 0.8 && halvings < 60; phase *= 0.5, part *= 0.5) ++halvings;
    return halvings;
  }

  double b_, f_, fastest_;
  std::array<double, terms> s_, v_;
};

}  // namespace strobe::impact::detail
