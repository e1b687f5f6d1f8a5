#include "common/impact/ode/couple_pieces.hpp"

namespace strobe::impact::detail {

namespace {

constexpr std::size_t kNodes = 12;
constexpr int kMaxHalvings = 16;

/// A part of a segment of a contact without an offset, which is in closed form everywhere on it.
class CouplePiece {
 public:
  CouplePiece(const CollocationConstants& c, const Segment& whole, const SegmentPoint& from, double x,
              double size) {
    segment_.mode = whole.mode;
    segment_.x = x;
    segment_.size = size;
    segment_.from = from.normal;
    segment_.start = from.tangential;
    segment_.nodes = kNodes;
    for (std::size_t i = 0; i < kNodes; ++i) {
      const double at = x + size * kGaussLegendre<kNodes>.node[i];
      const SegmentPoint p = point_on(c, whole, at);
      const double force = c.normal.force(p.normal), spin = c.spin(p.tangential);
      segment_.samples[i] = {kGaussLegendre<kNodes>.weight[i] * size * c.normal.pace(at),
                             force,
                             c.normal.force_rate(p.normal),
                             0.0,
                             p.tangential.slip,
                             p.tangential.stretch,
                             spin};
      const double share = std::min(std::max(p.normal.depth / c.system.radius, 0.0), 1.0);
      couple_[i] = size * c.normal.pace(at) * std::sqrt(share * (2.0 - share)) * force *
                   c.system.offset_direction(spin);
    }
  }

  const Segment& segment_to(const SegmentPoint& end) {
    segment_.end = end;
    return segment_;
  }

  bool resolved(double allowed) const {
    for (const std::size_t k : {kNodes - 2, kNodes - 1}) {
      double last = 0.0;
      for (std::size_t i = 0; i < kNodes; ++i) last += kGaussLegendre<kNodes>.coefficient[k][i] * couple_[i];
      if (!(std::abs(last) <= allowed)) return false;
    }
    return true;
  }

 private:
  Segment segment_;
  std::array<double, kNodes> couple_;
};

struct PieceWalk {
  VariationalEquations& equations;
  const CollocationConstants& c;
  const Segment& whole;
  double allowed;

  void advance(const SegmentPoint& from, double x, const SegmentPoint& to, double end, int halvings) {
    CouplePiece piece(c, whole, from, x, end - x);
    if (halvings == 0 || piece.resolved(allowed)) {
      equations.advance(piece.segment_to(to));
      return;
    }
    const double middle_x = 0.5 * (x + end);
    const SegmentPoint middle = whole_point_on(c, whole, middle_x);
    advance(from, x, middle, middle_x, halvings - 1);
    advance(middle, middle_x, to, end, halvings - 1);
  }
};

}  // namespace

void advance_in_pieces(VariationalEquations& equations, const CollocationConstants& c, const Segment& segment,
                       double tolerance) {
  // Without a couple its coefficients are none.
  Segment whole = segment;
  whole.couple.fill(0.0);
  whole.cosine.fill(0.0);
  whole.sine.fill(0.0);
  PieceWalk walk{equations, c, whole, 0.1 * tolerance};
  walk.advance({segment.from, segment.start}, segment.x, segment.end, segment.x + segment.used * segment.size,
               kMaxHalvings);
}

}  // namespace strobe::impact::detail
