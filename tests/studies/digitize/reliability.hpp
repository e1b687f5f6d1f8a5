// How true stated probabilities are. Deterministic; thread-safe; allocates.
#pragma once

#include <vector>

namespace strobe::studies::digitize {

/// A reliability diagram in words: what was stated of images, and of how many it is true.
class Reliability {
 public:
  enum class Is { ball, other_ball, none };
  void add(double probability, Is what);
  void add(const Reliability& other);
  /// By classes of probability: images, balls' and second balls' among them, the balls' share with its 95 %
  /// interval after Wilson, J. Am. Stat. Assoc. 22 (1927), and the mean of what was stated.
  void print() const;

 private:
  struct Class {
    int images = 0, balls = 0, others = 0;
    double stated = 0.0;
  };
  std::vector<Class> classes_;
};

}  // namespace strobe::studies::digitize
