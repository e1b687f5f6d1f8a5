// The variational equations of a contact solved by collocation: the derivatives of the tangential motion, at a fixed time,
// with respect to the dimensionless inputs of contact_system.hpp, carried from segment to segment.
//
// Along a segment the derivative d of the couple's rate, D' = G·h(w), is the only unknown:
//   d = G·h'(w)·dw + dG·h(w) + G·dh,   dw = dw0 + (dD + dP)/alpha + ..., dD the integral of d,
// and slipping dP is known, gripping it follows from d by variation of constants, as the motion itself does. At the nodes
// of the segment this is a linear system with one matrix for all inputs.
//
// At an event the friction is equal under both laws, and so is the motion's derivative. A segment that ends `late` after
// its event carries the old law's derivatives too far, which is put right to the square of that.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/collocation_segment.hpp"
#include "common/impact/ode/normal_partials.hpp"

namespace strobe::impact::detail {

enum SystemInput : std::size_t {
  kByZeta,
  kByGravity,
  kByMu,
  kByKt,
  kByCt,
  kByAlpha,
  kByDelta,
  kByReference,
  kByRadius,
  kByAlong,
  kBySlip,  ///< at touchdown
  kBySpin,
  kSystemInputs
};

using Partials = std::array<double, kSystemInputs>;

struct TangentialPartials {
  alignas(16) Partials couple{};
  alignas(16) Partials friction{};
  alignas(16) Partials stretch{};
  alignas(16) Partials path{};             ///< of friction's impulse
  alignas(16) Partials couple_integral{};  ///< over time
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
  using Rows = std::array<Partials, kMaxNodes>;

  void place_nodes(const Segment& segment);
  void place_couple(std::size_t i, const NodeSample& sample, const NormalState& normal);
  void place_slip(const Segment& segment);
  /// The start of a grip as its closed form has it, and the constants of its oscillation.
  struct GripStart {
    Partials first{}, second{}, rest{}, b{}, omega2{};
  };
  GripStart start_of_grip(const Segment& segment) const;
  void place_grip(const Segment& segment);
  void solve();
  Partials couple_integral(double elapsed) const;
  void finish_slip(const Segment& segment);
  void finish_grip(const Segment& segment);

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
  std::array<Nodes, kMaxNodes> matrix_;
  alignas(16) Rows rows_;  ///< right-hand sides, then the couple's rates times pace
  // Gripping: weights of the two integrals, and what drives them besides the couple.
  Nodes to_cosine_, to_sine_;
  struct Forcing {
    double alpha, kt, ct;
  };
  std::array<Forcing, kMaxNodes> forcing_;
};

}  // namespace strobe::impact::detail
