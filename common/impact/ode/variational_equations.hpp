// The variational equations of a contact solved by collocation: the derivatives of the tangential motion, at
// a fixed time, with respect to the dimensionless inputs of contact_system.hpp that a contact's coefficients
// change, carried from segment to segment.
//
// Along a segment the derivative d of the couple's rate, D' = G·h(w), is the only unknown:
//   d = G·h'(w)·dw + dG·h(w) + G·dh,   dw = (dD + dP)/alpha + ..., dD the integral of d,
// and slipping dP is known, gripping it follows from d by variation of constants, as the motion itself does.
// At the nodes of the segment this is a linear system, M·d = r, with one matrix for all inputs. Of d only
// sums at the segment's end are asked for, weights·d: the transposed system gives the weights of r, three of
// them for however many inputs.
//
// At an event the friction is equal under both laws, and so is the motion's derivative. A segment that ends
// `late` after its event carries the old law's derivatives too far, which is put right to the square of that.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/collocation_segment.hpp"

namespace strobe::impact::detail {

enum SystemInput : std::size_t {
  kByGravity,
  kByMu,
  kByKt,
  kByCt,
  kByAlpha,
  kByDelta,
  kByReference,
  kByRadius,
  kByAlong,
  kSystemInputs
};

using Partials = std::array<double, kSystemInputs>;

template <std::size_t n>
inline void add(std::array<double, n>& to, const std::array<double, n>& what, double times) {
  for (std::size_t k = 0; k < n; ++k) to[k] += times * what[k];
}

/// The derivatives with respect to gravity of what NormalMotion gives at a time.
struct NormalPartials {
  double depth = 0.0, rate = 0.0, force = 0.0, force_rate = 0.0, impulse = 0.0;
};
NormalPartials normal_partials(const System& system, const NormalState& at);

struct TangentialPartials {
  alignas(16) Partials couple{};
  alignas(16) Partials friction{};
  alignas(16) Partials stretch{};
};

class VariationalEquations {
 public:
  explicit VariationalEquations(const CollocationConstants& constants)
      : c_(constants), s_(constants.system) {}

  /// From the segment's start to its end.
  void advance(const Segment& segment);

  /// The law of friction changes from that of `segment`, at its end, to `next`.
  void change_law(const Segment& segment, ContactMode next);

  const TangentialPartials& partials() const { return at_; }

 private:
  using Nodes = std::array<double, kMaxNodes>;
  /// What is asked for at a segment's end: the couple's impulse since its start, and gripping the two
  /// integrals of variation of constants.
  enum End : std::size_t { kImpulse, kCosine, kSine, kEnds };
  using Ends = std::array<double, kEnds>;

  void place_nodes(const Segment& segment);
  void place_couple(std::size_t i, const NodeSample& sample, const NormalState& normal);
  /// The start of a grip as its closed form has it, and the constants of its oscillation.
  struct GripStart {
    Partials first{}, second{}, rest{}, b{}, omega2{};
  };
  GripStart start_of_grip(const Segment& segment) const;
  void weigh_nodes(bool grips);
  void solve_slip(const Segment& segment);
  void solve_grip(const Segment& segment, const GripStart& start);
  void solve();
  void sum(const Partials& what, const Ends& times);
  void sum(SystemInput input, const Ends& times);
  void sum_given();
  void finish_slip(const Segment& segment);
  void finish_grip(const Segment& segment, const GripStart& start);

  Partials slip_of(const TangentialPartials& at, double tau, double spin) const;
  Partials slipping_stretch(const NormalState& normal, const NormalPartials& by, double sign) const;
  Partials friction_of(ContactMode mode, const SegmentPoint& end, const NormalPartials& by) const;
  Partials stretch_rate_of(ContactMode mode, const SegmentPoint& end, const NormalPartials& by,
                           const Partials& friction) const;

  const CollocationConstants& c_;
  const System& s_;
  TangentialPartials at_;

  /// What the value at node j adds to the integral up to node i.
  double integral(std::size_t j, std::size_t i) const { return integral_[j * points_ + i]; }
  template <std::size_t n>
  void use_rule(const Segment& segment);

  std::size_t nodes_ = 0, points_ = 0;
  const double* node_ = nullptr;
  const double* integral_ = nullptr;
  alignas(16) std::array<double, kMaxNodes + 1> weight_;  ///< of the integral up to the segment's end
  Nodes tau_, pace_;
  Nodes of_spin_;  ///< of the couple's rate times pace
  std::array<NormalPartials, kMaxNodes> by_;
  struct Given {
    double gravity, radius, delta, reference;
  };
  std::array<Given, kMaxNodes> given_;   ///< derivatives of the couple's rate times pace, the spin kept
  std::array<Nodes, kMaxNodes> matrix_;  ///< transposed
  alignas(16) std::array<Ends, kMaxNodes> weights_;  ///< of the nodes in each end
  std::array<Partials, kEnds> ends_;
  // Gripping: weights of the two integrals, and what drives them besides the couple.
  Nodes to_cosine_, to_sine_;
  struct Forcing {
    double alpha, kt, ct;
  };
  std::array<Forcing, kMaxNodes> forcing_;
};

}  // namespace strobe::impact::detail
