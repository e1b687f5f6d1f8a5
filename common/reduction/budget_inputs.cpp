#include "common/reduction/budget_inputs.hpp"

#include <cassert>
#include <cmath>
#include <utility>

namespace strobe::reduction {
namespace {

constexpr double kPercent = 100.0;

/// A ball is as large to the air and to its rim as on the photograph.
void enlarge_ball(Observations& all, double by_m) {
  all.ball_diameter_m += by_m;
  all.ball.diameter_m += by_m;
}

void enlarge_images(Observations& all, double by_m) {
  for (Observation& o : all.images) o.diameter_m += by_m;
}

/// Takes a fit apart.
class Collector {
 public:
  explicit Collector(const ShotFit& fit) : estimated_(fit) { inputs_.fit = fit; }

  Inputs run() && {
    images();
    surface();
    flash_times();
    air(true);
    scale();
    for (std::size_t i = 0; i < seen().map_errors.size(); ++i) {
      add({.source = Source::map, .number = static_cast<int>(i) + 1, .input_sd = 1.0, .input_unit = "sd"},
          [i](ShotFit& fit, double sds) { shift(fit.observations.map_errors[i], sds, fit.observations); });
    }
    size(Source::ball_diameter, seen().ball_diameter_sd_m.value_or(0.0), enlarge_ball);
    size(Source::all_diameters, seen().shared_diameter_sd_m.value_or(0.0), enlarge_images);
    air(false);
    spin_decay();
    believe_noise();
    return std::move(inputs_);
  }

 private:
  const Observations& seen() const { return estimated_.observations; }

  void add(const BudgetSource& source, std::function<void(ShotFit&, double)> move) {
    inputs_.sources.push_back(source);
    add_to_last(std::move(move));
  }

  void size(Source source, double sd_m, void (*enlarge)(Observations&, double by_m)) {
    if (!(sd_m > 0.0)) return;
    add({.source = source, .input_sd = 1e3 * sd_m, .input_unit = "mm"},
        [enlarge, sd_m](ShotFit& fit, double sds) { enlarge(fit.observations, sds * sd_m); });
  }

  void add_to_last(std::function<void(ShotFit&, double)> move) {
    assert(!inputs_.sources.empty());
    inputs_.inputs.push_back({inputs_.sources.size() - 1, std::move(move)});
  }

  BudgetSource noise_source(Source source, NoiseGroup group) const {
    BudgetSource s{.source = source};
    if (group == NoiseGroup::stated) return s;
    const auto index = static_cast<std::size_t>(group);
    s.type = EvaluationType::a;
    s.factor = static_cast<int>(index);
    s.degrees_of_freedom = estimated_.variance_components[index].degrees_of_freedom;
    return s;
  }

  /// Of one kind: a source for each group of noise that there is.
  template <typename Add>
  void by_noise(Source source, bool Observation::*use, NoiseGroup Observation::*noise, const Add& each) {
    for (std::size_t g = 0; g < kNoiseGroupCount; ++g) {
      bool any = false;
      for (std::size_t i = 0; i < seen().images.size(); ++i) {
        const Observation& o = seen().images[i];
        if (!(o.*use) || o.*noise != static_cast<NoiseGroup>(g)) continue;
        if (!std::exchange(any, true))
          inputs_.sources.push_back(noise_source(source, static_cast<NoiseGroup>(g)));
        each(i, o);
      }
    }
  }

  void images() {
    by_noise(Source::centres, &Observation::use_centre, &Observation::centre_noise,
             [this](std::size_t i, const Observation& o) {
               const double unit = seen().unit(o.centre_noise);
               const CholeskyFactor& l = o.centre_cholesky_m;
               move_centre(i, {unit * l.xx, unit * l.yx});
               move_centre(i, {0.0, unit * l.yy});
             });
    by_noise(Source::diameters, &Observation::use_diameter, &Observation::diameter_noise,
             [this](std::size_t i, const Observation& o) {
               add_to_last([i, sd = seen().diameter_sd(o)](ShotFit& fit, double sds) {
                 fit.observations.images[i].diameter_m += sds * sd;
               });
             });
    by_noise(Source::equators, &Observation::use_equator, &Observation::equator_noise,
             [this](std::size_t i, const Observation& o) {
               add_to_last([i, sd = seen().equator_sd(o)](ShotFit& fit, double sds) {
                 fit.observations.images[i].equator_rad += sds * sd;
               });
             });
  }

  void move_centre(std::size_t i, const Eigen::Vector2d& by_m) {
    add_to_last([i, by_m](ShotFit& fit, double sds) { fit.observations.images[i].centre_m += sds * by_m; });
  }

  void surface() {
    inputs_.sources.push_back(noise_source(Source::surface, seen().surface_noise));
    for (std::size_t i = 0; i < seen().surface_m.size(); ++i) {
      for (const Eigen::Vector2d& axis : {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0)}) {
        add_to_last([i, by = Eigen::Vector2d(seen().surface_sd() * axis)](ShotFit& fit, double sds) {
          fit.observations.surface_m[i] += sds * by;
        });
      }
    }
  }

  void flash_times() {
    bool any = false;
    for (std::size_t i = 0; i < seen().images.size(); ++i) {
      const Observation& o = seen().images[i];
      if (!(o.time_sd_s > 0.0) || !(o.use_centre || o.use_equator)) continue;
      if (!std::exchange(any, true)) inputs_.sources.push_back({.source = Source::flash_times});
      add_to_last(
          [i, sd = o.time_sd_s](ShotFit& fit, double sds) { fit.observations.images[i].time_s += sds * sd; });
    }
  }

  void scale() {
    if (!seen().scale || !(seen().scale_sd > 0.0)) return;
    add({.source = Source::scale, .input_sd = kPercent * seen().scale_sd / *seen().scale, .input_unit = "%"},
        [sd = seen().scale_sd](ShotFit& fit, double sds) { *fit.observations.scale += sds * sd; });
  }

  /// What was known of the air before, where an open spin says nothing of it, or where it does.
  void air(bool open) {
    const AirErrors& prior = estimated_.air_fit.prior;
    if (!open) {
      move_air(kDragError, 1.0,
               {.source = Source::drag,
                .input_sd = kPercent * estimated_.air.law.drag_share_sd(),
                .input_unit = "%"});
    }
    for (std::size_t leg = 0; leg < 2; ++leg) {
      const std::size_t p = kLiftError[leg];
      if (prior[p].open != open) continue;
      // A larger coefficient lifts backspin and pulls down topspin.
      const auto& spin = estimated_.spin[leg];
      const double sign = !open && spin && spin->omega_radps < 0.0 ? -1.0 : 1.0;
      const Source known = leg == 0 ? Source::lift_incoming : Source::lift_rebound;
      BudgetSource source{.source = open ? Source::unknown_spin : known};
      if (open) source.number = static_cast<int>(leg) + 1;
      if (!open) {
        source.input_sd = kPercent * estimated_.air.law.lift_share_sd;
        source.input_unit = "%";
      }
      move_air(p, sign, source);
    }
  }

  void move_air(std::size_t p, double sign, const BudgetSource& source) {
    const double sd = estimated_.air_fit.prior[p].sd;
    if (!(sd > 0.0) || !std::isfinite(sd)) return;
    add(source, [p, by = sign * sd](ShotFit& fit, double sds) { fit.air_shift[p] += sds * by; });
  }

  void spin_decay() {
    const double sd = estimated_.spin_decay_sd_per_m;
    if (!(sd > 0.0)) return;
    add({.source = Source::spin_decay, .input_sd = kPercent * sd, .input_unit = "%/m"},
        [sd](ShotFit& fit, double sds) { fit.spin_decay_per_m += sds * sd; });
  }

  void believe_noise() {
    Observations& all = inputs_.fit.observations;
    for (Observation& o : all.images) {
      const double unit = all.unit(o.centre_noise);
      o.centre_cholesky_m.xx *= unit;
      o.centre_cholesky_m.yx *= unit;
      o.centre_cholesky_m.yy *= unit;
      o.diameter_sd_m = all.diameter_sd(o);
      o.equator_sd_rad = all.equator_sd(o);
      o.centre_noise = o.diameter_noise = o.equator_noise = NoiseGroup::stated;
    }
    all.surface_sd_m = all.surface_sd();
    all.surface_noise = NoiseGroup::stated;
  }

  const ShotFit& estimated_;
  Inputs inputs_;
};

}  // namespace

Inputs inputs_of(const ShotFit& fit) { return Collector(fit).run(); }

Quantities numbers(ShotFit moved, const PropagationOptions& propagation) {
  refit(moved, moved.effects);
  Readout readout;
  propagate(moved, propagation, readout);
  return readout.value;
}

}  // namespace strobe::reduction
