// How many digits each closed form of the analysis keeps: the form in double precision, and the textbook's
// way of writing it, against a reference of 50 digits, over the whole range of its arguments. The references
// are written from the physics, not from the product's formulas; natural scales are named with each form.
// Deterministic for a given seed; single-threaded; allocates.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace strobe::numerics {

using Random = std::mt19937_64;

/// One argument of a form: the values tried by structure (both ends, their neighbours, a grid, special
/// values) and how one is drawn at random.
struct Axis {
  std::string name;
  std::vector<double> structured;
  std::function<double(Random&)> draw;
};

/// Positive, even in the logarithm.
Axis logarithmic(std::string name, double low, double high, std::vector<double> special = {});
/// Either sign, even in the logarithm of the magnitude, zero now and then.
Axis either_sign(std::string name, double least, double most, std::vector<double> special = {});
/// Even in low…high.
Axis even(std::string name, double low, double high, std::vector<double> special = {});
/// 0…1 with both ends approached as closely as doubles allow.
Axis unit_interval(std::string name, double low = 0.0);

/// Largest errors of one output of a form.
struct Worst {
  std::size_t samples = 0;
  double error = -1.0;  ///< |computed - true| over the larger of |true| and the natural scale
  double ulps = 0.0;    ///< the same difference in units of the last place of that size
  std::string argument;
  std::optional<double> textbook_error;  ///< absent: the form is written as the textbook does
  std::string textbook_argument;
};

/// Takes the errors of one sample; wide.hpp computes them.
class Tally {
 public:
  explicit Tally(std::string argument) : argument_(std::move(argument)) {}
  void use(std::map<std::string, Worst>& worst) { worst_ = &worst; }
  void record(const std::string& output, double error, double ulps, std::optional<double> textbook_error);

 private:
  std::string argument_;
  std::map<std::string, Worst>* worst_ = nullptr;
};

struct Form {
  std::string name;
  std::string scale;      ///< the natural scale of its outputs
  std::string rewritten;  ///< how it differs from the textbook, empty where it does not
  std::vector<Axis> axes;
  std::function<void(std::span<const double> arguments, Tally&)> evaluate;
  double tolerance = 1e-13;
};

struct Measured {
  std::string form, output, scale, rewritten;
  double tolerance = 0.0;
  Worst worst;
};

/// Every form of the analysis, grouped by subject.
std::vector<Form> all_forms();

/// Half of the samples by structure, half at random; at least one of each. One row for each output.
std::vector<Measured> measure(const Form& form, std::size_t samples, std::uint64_t seed);

}  // namespace strobe::numerics
