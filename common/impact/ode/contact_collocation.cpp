#include "common/impact/ode/contact_collocation.hpp"

#include <cassert>

#include "common/impact/ode/friction_law.hpp"

namespace strobe::impact::detail {

namespace {

template <std::size_t n, std::size_t terms>
class Collocation {
 public:
  Collocation(const CollocationConstants& constants, double tolerance, bool along, Segments* stored,
              std::vector<SegmentStart>* starts)
      : c_(constants),
        s_(constants.system),
        tolerance_(tolerance),
        along_(along),
        stored_(stored),
        starts_(starts),
        allowed_(allowance(c_, tolerance)),
        solver_(c_, allowed_),
        law_(c_, tolerance) {
    mode_ = initial_mode(s_);
    out_.started_gripping = mode_ == ContactMode::grips;
    at_.slip = s_.slip0;
    if (s_.slip0 == 0.0) {
      out_.slip_zero_tau = 0.0;
      out_.slip_zero_first = true;
    }
    if (stored_) stored_->count = 0;
    full_x_ = full_footprint();
  }

  std::optional<CollocatedContact> run() {
    while (x_ < c_.normal.end()) {
      if (++out_.segments > static_cast<int>(kMaxSegments) || !step()) return std::nullopt;
    }
    assert(!stored_ || stored_->count == static_cast<std::size_t>(out_.segments));
    out_.tau = c_.normal.release_tau();
    out_.rate = from_.rate;
    out_.release = at_;
    return out_;
  }

  /// Error of D that a segment may make: a quarter of the tolerance in w = R·omega, relative to the scale of
  /// tangential changes.
  static double allowance(const CollocationConstants& c, double tolerance) {
    return 0.25 * tolerance * c.system.alpha * c.system.tangential_scale();
  }

 private:
  static constexpr int kMaxAttempts = 12;
  static constexpr int kMaxGrazingAttempts = 4;
  static constexpr int kMaxSwitches = 32;
  /// Growth of exp(b·t) and of the hyperbolic functions within a segment: what the difference of its ends
  /// loses.
  static constexpr double kMaxGrowth = 4.0;
  /// Decay, within a segment, of what the stretch of a slip began with: Gauss's rule of n nodes integrates
  /// its square to 1e-10 with 8 nodes and 1e-14 with 12.
  static constexpr double kMaxDecay = n <= 8 ? 3.0 : 5.0;

  /// Where the depth passes the radius, up and down: the footprint's law changes.
  std::array<double, 2> full_footprint() const {
    const double never = 2.0;
    // Without damping the depth is at most 2g + 1.
    if (s_.delta == 0.0 || s_.radius > 1.0 + 2.0 * s_.gravity) return {never, never};
    const double deepest = c_.normal.deepest_tau();
    if (!(c_.normal.at(deepest).depth > s_.radius)) return {never, never};
    const double release = c_.normal.release_tau();
    const bool deep_at_release = c_.normal.at(release).depth > s_.radius;
    return {c_.normal.x_of(c_.normal.passes(s_.radius, 0.0)),
            deep_at_release ? never : c_.normal.x_of(c_.normal.passes(s_.radius, release))};
  }

  double limit_of_segment() const {
    double limit = c_.normal.end();
    for (const double x : full_x_)
      if (x > x_ && x < limit) limit = x;
    const double tau = longest();
    if (from_.tau + tau < c_.normal.tau(limit)) limit = std::min(limit, c_.normal.x_of(from_.tau + tau));
    return limit;
  }

  /// Time for which the closed forms keep their digits and the nodes resolve them.
  double longest() const {
    if (mode_ != ContactMode::grips) {
      if (c_.kappa == 0.0) return 1e300;
      const double transient = s_.kt * std::abs(at_.stretch - c_.slipping_stretch(from_, direction(mode_)));
      return transient <= 0.01 * allowed_ ? 1e300 : kMaxDecay / c_.kappa;
    }
    const double q = std::sqrt(std::abs(c_.omega2));
    const double growth = c_.b + (c_.omega2 < 0.0 ? q : 0.0);
    // The nodes sample the law of friction, and where energies are asked for they integrate squares.
    const double turns = c_.omega2 > 0.0 ? q / ((along_ ? 0.4 : 0.5) * static_cast<double>(n)) : 0.0;
    return 1.0 / std::max({growth / kMaxGrowth, turns, 1e-300});
  }

  /// Solves from here to `x` in the present mode, even if that looks hopeless where a longer segment was
  /// solved.
  bool solve_to(double x, bool persist = false) {
    segment_.mode = mode_;
    segment_.x = x_;
    segment_.size = x - x_;
    segment_.from = from_;
    segment_.start = at_;
    to_.tau = x >= c_.normal.end() ? c_.normal.release_tau() : c_.normal.tau(x);
    out_.evaluations += static_cast<int>(n);
    return solver_.solve(segment_, to_, persist);
  }

  void sample() { law_.sample(segment_, solver_, just_switched_); }

  double guess() const {
    if (mode_ == ContactMode::grips || guessed_) return 2.0;
    // Sliding as a rigid contact, without an offset and damping: gripping after 1 - cos(tau) of the impulse.
    const double needed = std::abs(s_.slip0), largest = c_.beta * s_.mu;
    if (!(needed < 1.9 * largest)) return 2.0;
    return 1.2 * half_wave(0.5 * needed / largest) + 0.02;
  }

  /// x at which a share of a half wave's area is passed, to a hundredth.
  static double half_wave(double share) {
    const bool low = share <= 0.5;
    const double r = std::sqrt(std::sqrt(low ? share : 1.0 - share));
    const double x = r * (0.464296 + r * (0.006923 + r * 0.166477));
    return low ? x : 1.0 - x;
  }

  bool step() {
    const double limit = limit_of_segment();
    double to = limit;
    if (const double g = guess(); x_ + g < limit) to = x_ + g;
    guessed_ = true;
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      if (to < limit && to - x_ < 1e-6) return false;
      const bool converged = solve_to(to);
      const Spins spins = spins_of_segment();
      const double error = error_of_segment(spins) / allowed_;
      if ((!converged && error <= 1.0) || (converged && !spin_resolved(spins))) {
        to = x_ + 0.5 * (to - x_);
        continue;
      }
      if (error > 1.0) {
        const double power = along_ ? 1.0 / static_cast<double>(n) : 0.5 / static_cast<double>(n);
        to = x_ + (to - x_) * std::clamp(0.9 * std::pow(error, -power), 0.15, 0.85);
        continue;
      }
      sample();
      if (!law_.accept_start(switch_law_)) {
        if (++start_attempts_ > 4) return false;
        to = x_ + 0.2 * (to - x_);
        continue;
      }
      if (attempt < kMaxGrazingAttempts && law_.may_graze()) {
        to = x_ + 0.6 * (to - x_);
        continue;
      }
      const std::optional<double> event = law_.find_event();
      if (!event) {
        end_ = solver_.end();
        return advance(to, false);
      }
      const int before = switches_;
      const bool inside = !along_ && solver_.error_inside() <= allowed_ && switch_inside(*event);
      if (inside || switch_near(x_ + (to - x_) * *event)) return true;
      if (switches_ != before) return false;
      // The polynomial of a long segment missed it.
      to = x_ + std::clamp(2.0 * *event, 0.02, 0.5) * (to - x_);
    }
    return false;
  }

  /// Leaves the segment at the event, by its polynomial. Returns false if that is not near `found`: the law's
  /// own polynomial does not resolve it there.
  bool switch_inside(double found) {
    const FrictionLaw law(c_, mode_);
    double share = found;
    for (int i = 0; i < 4; ++i) {
      if (!(std::abs(share - found) <= 0.1 * found && share < 1.0)) return false;
      const SegmentPoint at = solver_.point_at(segment_, share);
      const double end = law.value(at), rate = law.rate(at);
      if (!(rate < 0.0)) return false;
      const double late = end / rate;
      if (std::abs(0.5 * law.weight() * end * late) <= 0.1 * allowed_) {
        to_ = at.normal;
        end_ = at.tangential;
        event_tau_ = to_.tau - late;
        return advance(segment_.x + segment_.size * share, true);
      }
      share -= late / (segment_.size * c_.normal.pace(segment_.x + segment_.size * share));
    }
    return false;
  }

  /// Solves again up to the event; once more where the polynomial missed it. An error of the time at which
  /// one friction follows the other, to which it is then equal, counts by its square. Where energies are
  /// asked for, the time itself counts: without a dashpot the stretch jumps by what the law is missed by.
  bool switch_near(double x) {
    const FrictionLaw law(c_, mode_);
    for (int i = 0; i < 6; ++i) {
      if (!(x > x_) || x > c_.normal.end() || !solve_to(x, true)) return false;
      sample();
      const double end = law_.at_end();
      const double rate = law.rate({to_, solver_.end()});
      if (!(rate < 0.0)) return false;
      const double late = end / rate;  // after the event
      const double impulse = std::abs(0.5 * law.weight() * end * late);
      const bool in_time = !along_ || std::abs(late) <= (0.03 * tolerance_ + 2e-15) * to_.tau;
      if (impulse <= 0.3 * allowed_ && in_time) {
        end_ = solver_.end();
        event_tau_ = to_.tau - late;
        return advance(x, true);
      }
      const double pace = c_.normal.pace(x);
      if (!(pace > 0.0)) return false;
      x -= std::clamp(late / pace, -0.2 * (x - x_), 0.2 * (x - x_));
    }
    return false;
  }

  /// Least and largest |w| of a segment's points, 0 where it passes through 0.
  struct Spins {
    double least, most, range;
  };
  Spins spins_of_segment() const {
    const double first = c_.spin(at_);
    double low = first, high = first;
    for (const double spin : solver_.spin()) {
      low = std::min(low, spin);
      high = std::max(high, spin);
    }
    const double a = std::abs(low), b = std::abs(high);
    return {low * high > 0.0 ? std::min(a, b) : 0.0, std::max(a, b), high - low};
  }

  /// Where the spin changes by several times its distance from the couple's poles, at ± i·w0, what they add
  /// is small against the whole and falls off more slowly: then the last coefficients count by themselves.
  double error_of_segment(const Spins& w) const {
    const double at_end = solver_.error_at_end();
    if (along_) return std::max(at_end, solver_.error_along());
    if (at_end > allowed_ || s_.delta == 0.0 || s_.ahead != 0.0) return at_end;
    const bool by_poles = w.most * w.most > 16.0 * (w.least * w.least + s_.w_ref * s_.w_ref);
    return by_poles ? std::max(at_end, solver_.error_along()) : at_end;
  }

  /// The offset turns round with the spin within w0 of 0, where the couple has its poles. The Legendre
  /// coefficients see that if the nodes do; none is before the first and after the last of them.
  bool spin_resolved(const Spins& w) const {
    if (s_.delta == 0.0 || s_.ahead != 0.0) return true;
    const double w_ref2 = s_.w_ref * s_.w_ref;
    if (w.range * w.range <= 0.25 * (w.least * w.least + w_ref2)) return true;
    const auto resolved = [w_ref2](double a, double b, double share) {
      const double least = a * b < 0.0 ? 0.0 : std::min(std::abs(a), std::abs(b));
      return (a - b) * (a - b) <= share * share * (least * least + w_ref2);
    };
    const auto& spin = solver_.spin();
    for (std::size_t i = 1; i < n; ++i)
      if (!resolved(spin[i - 1], spin[i], 2.0)) return false;
    return resolved(c_.spin(at_), spin[0], 0.5) && resolved(spin[n], spin[n - 1], 0.5);
  }

  bool advance(double x, bool event) {
    note_slip_zero(x);
    if (stored_) {
      solver_.sample(segment_);
      if (along_) solver_.interpolate(segment_);
      segment_.used = (x - segment_.x) / segment_.size;
      segment_.end = {to_, end_};
      stored_->all[stored_->count++] = segment_;
    }
    if (starts_) starts_->push_back({mode_, x_, from_, at_});
    const FrictionLaw law(c_, mode_);
    switch_law_ = event && s_.ct > 0.0 ? 2.0 * std::abs(law.value({to_, end_})) : 0.0;
    x_ = x;
    from_ = to_;
    at_ = end_;
    start_attempts_ = 0;
    just_switched_ = event;
    if (!event) return true;
    switches_ += 1;
    const bool gripped = mode_ == ContactMode::grips;
    mode_ = gripped ? law.breaks_towards(at_) : ContactMode::grips;
    if (s_.ct == 0.0 && gripped) at_.stretch = c_.slipping_stretch(from_, direction(mode_));
    if (!gripped && !out_.first_grip_tau) out_.first_grip_tau = event_tau_;
    return switches_ < kMaxSwitches;
  }

  void note_slip_zero(double x) {
    if (out_.slip_zero_tau) return;
    const double first = at_.slip;
    const auto opposite = [first](double slip) { return first > 0.0 ? slip <= 0.0 : slip >= 0.0; };
    bool found = opposite(end_.slip);
    const double share = (x - segment_.x) / segment_.size;
    for (std::size_t i = 0; i < n && kGaussLegendre<n>.share[i] < share; ++i)
      found = found || opposite(solver_.slip()[i]);
    if (!found) return;
    out_.slip_zero_tau = to_.tau;
    out_.slip_zero_first = !out_.first_grip_tau;
  }

  const CollocationConstants& c_;
  const System& s_;
  double tolerance_;
  bool along_;
  Segments* stored_;
  std::vector<SegmentStart>* starts_;
  double allowed_;
  SegmentSolver<n, terms> solver_;
  LawAlongSegment<n> law_;
  CollocatedContact out_;
  ContactMode mode_ = ContactMode::grips;
  double x_ = 0.0;
  NormalState from_, to_;
  TangentialState at_, end_;
  Segment segment_;
  std::array<double, 2> full_x_{};
  double switch_law_ = 0.0, event_tau_ = 0.0;
  bool just_switched_ = false, guessed_ = false;
  int start_attempts_ = 0, switches_ = 0;
};

template <std::size_t n, std::size_t terms>
std::optional<CollocatedContact> by_nodes(const CollocationConstants& c, double tolerance, bool along,
                                          Segments* segments, std::vector<SegmentStart>* starts) {
  return Collocation<n, terms>(c, tolerance, along, segments, starts).run();
}

/// In one segment, which is shorter than one that was solved; in more where that fails nevertheless.
template <std::size_t n, std::size_t terms>
SegmentPoint point_by_nodes(const CollocationConstants& c, double tolerance, const SegmentStart& start,
                            double tau) {
  constexpr double kShortest = 1e-9;
  SegmentSolver<n, terms> solver(c, Collocation<n, terms>::allowance(c, tolerance));
  Segment segment;
  segment.mode = start.mode;
  segment.x = start.x;
  segment.from = start.from;
  segment.start = start.start;
  const double end = c.normal.x_of(tau);
  double size = end - start.x;
  while (segment.x < end) {
    const bool last = segment.x + size >= end;
    segment.size = last ? end - segment.x : size;
    NormalState to;
    to.tau = last ? tau : c.normal.tau(segment.x + size);
    if (!solver.solve(segment, to, true) && size > kShortest) {
      size *= 0.5;
      continue;
    }
    segment.x += segment.size;
    segment.from = to;
    segment.start = solver.end();
    if (last) break;
  }
  return {segment.from, segment.start};
}

template <std::size_t node_count, std::size_t term_count>
struct Rule {
  static constexpr std::size_t nodes = node_count, terms = term_count;
};

/// What `use` gives with the nodes that suit a tolerance of a segment's end.
template <typename Use>
auto by_tolerance(double tolerance, const Use& use) {
  if (tolerance > 3e-5) return use(Rule<7, 9>{});
  if (tolerance > 3e-8) return use(Rule<9, 12>{});
  if (tolerance > 3e-11) return use(Rule<11, 15>{});
  return use(Rule<13, 17>{});
}

}  // namespace

std::optional<CollocatedContact> collocate(const CollocationConstants& c, double tolerance, bool along,
                                           Segments* segments) {
  const auto solve = [&](auto rule) {
    return by_nodes<rule.nodes, rule.terms>(c, tolerance, along, segments, nullptr);
  };
  if (!along) return by_tolerance(tolerance, solve);
  return tolerance > 3e-8 ? solve(Rule<8, 17>{}) : solve(Rule<12, 17>{});
}

std::optional<CollocatedContact> collocate(const CollocationConstants& c, double tolerance,
                                           std::vector<SegmentStart>& starts) {
  return by_tolerance(tolerance, [&](auto rule) {
    return by_nodes<rule.nodes, rule.terms>(c, tolerance, false, nullptr, &starts);
  });
}

SegmentPoint point_at(const CollocationConstants& c, double tolerance, const SegmentStart& start,
                      double tau) {
  return by_tolerance(
      tolerance, [&](auto rule) { return point_by_nodes<rule.nodes, rule.terms>(c, tolerance, start, tau); });
}

}  // namespace strobe::impact::detail
