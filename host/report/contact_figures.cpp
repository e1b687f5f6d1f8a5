// Figures 4 to 17 of the thesis, of one's own images in contact.
#include "host/report/contact_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "common/reduction/observations.hpp"
#include "common/units/angles.hpp"
#include "host/assembly/assemble.hpp"
#include "host/report/sections.hpp"
#include "host/thesis/figures.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::report {

namespace {

using reduction::Observation;
using reduction::Observations;
using reduction::Quantity;

/// The motion at touchdown and what the rotation is expected to be from it.
struct Touchdown {
  double time_s = 0.0;
  double x_m = 0.0;
  std::optional<double> equator_rad;
  double omega_td_radps = 0.0, omega_lo_radps = 0.0, dwell_s = 0.0;

  /// For a spin that changes evenly: good to much less than the quarter turn that tells equators apart.
  double expected_rotation_rad(double since_s) const {
    return omega_td_radps * since_s + 0.5 * (omega_lo_radps - omega_td_radps) * since_s * since_s / dwell_s;
  }
};

const Observation* last_incoming(const Observations& all) {
  const Observation* last = nullptr;
  for (const Observation& image : all.images)
    if (image.leg == strobe::Leg::incoming && image.use_centre) last = &image;
  return last;
}

std::optional<Touchdown> touchdown(const Observations& all, const reduction::Readout& readout) {
  const auto& value = readout.value;
  const auto vx = value[Quantity::vx_td_mps], vy = value[Quantity::vy_td_mps];
  const auto in = value[Quantity::omega_td_radps], out = value[Quantity::omega_lo_radps];
  const auto dwell_ms = value[Quantity::dwell_time_ms];
  const Observation* image = last_incoming(all);
  if (!image || !vx || !vy || !in || !out || !dwell_ms || !(*vy < 0.0) || !(*dwell_ms > 0.0))
    return std::nullopt;
  const double to_go_s = (image->centre_m.y() - 0.5 * all.ball_diameter_m) / -*vy;
  Touchdown td{.time_s = image->time_s + to_go_s,
               .x_m = image->centre_m.x() + *vx * to_go_s,
               .equator_rad = {},
               .omega_td_radps = *in,
               .omega_lo_radps = *out,
               .dwell_s = 1e-3 * *dwell_ms};
  if (image->use_equator) td.equator_rad = image->equator_rad + *in * to_go_s;
  return td;
}

std::optional<double> rotation_rad(const Touchdown& td, const reduction::BallImage& image,
                                   const Observation& observed, double since_s) {
  if (!td.equator_rad || !image.equator_rad) return std::nullopt;
  const double expected = td.expected_rotation_rad(since_s);
  return expected + std::remainder(observed.equator_rad - *td.equator_rad - expected, strobe::kPi);
}

/// A cubic has four coefficients; one more image tells how well it fits.
constexpr std::size_t kMinImages = 5;

struct ContactImages {
  data::ContactSet set;
  std::size_t images = 0;
};

/// The group's means as a condition of the thesis. Returns nullopt where a number, or a spin that it knows,
/// is missing.
std::optional<thesis::Condition> condition_of(const ConditionGroup& group) {
  int angle = 0;
  const char* const end = group.angle.data() + group.angle.size();
  const auto read = std::from_chars(group.angle.data(), end, angle);
  if (!is_known_spin(group.spin) || read.ec != std::errc() || read.ptr != end) return std::nullopt;
  if (std::ranges::any_of(kEssential, [&](Quantity q) { return group.of(q).n == 0; })) return std::nullopt;
  thesis::Condition c;
  c.spin = group.spin;
  c.angle_label_deg = angle;
  c.n_incoming = c.n_rebound = c.n_system = group.summary.counted;
  const auto mean_sd = [&](Quantity q) {
    return thesis::MeanSd{group.of(q).mean, group.of(q).scatter_sd.value_or(0.0)};
  };
  c.theta_in_deg = mean_sd(Quantity::theta_in_deg);
  c.vx_td_mps = mean_sd(Quantity::vx_td_mps);
  c.vy_td_mps = mean_sd(Quantity::vy_td_mps);
  c.v_td_mps = mean_sd(Quantity::v_td_mps);
  c.omega_td_radps = mean_sd(Quantity::omega_td_radps);
  c.theta_out_deg = mean_sd(Quantity::theta_out_deg);
  c.vx_lo_mps = mean_sd(Quantity::vx_lo_mps);
  c.vy_lo_mps = mean_sd(Quantity::vy_lo_mps);
  c.v_lo_mps = mean_sd(Quantity::v_lo_mps);
  c.omega_lo_radps = mean_sd(Quantity::omega_lo_radps);
  c.e = mean_sd(Quantity::e);
  c.mu = mean_sd(Quantity::mu);
  c.dwell_distance_cm = mean_sd(Quantity::dwell_distance_cm);
  c.dwell_time_ms = mean_sd(Quantity::dwell_time_ms);
  return c;
}

/// Fractions of each shot's own contact; rotations of `total_rotation_rad`.
ContactImages images_of(const ConditionGroup& group, double total_rotation_rad) {
  ContactImages out;
  out.set.name = group.key;
  out.set.rows.push_back({0.0, 0.0, 0.0, 0.0});
  for (const ReportShot& each : group.counted) {
    const auto& readout = each.shot->readout;
    const auto dwell_ms = readout.value[Quantity::dwell_time_ms],
               distance_cm = readout.value[Quantity::dwell_distance_cm];
    if (!each.shot->summary || each.shot->digitizations.empty() || !dwell_ms || !distance_cm ||
        !(*distance_cm > 0.0))
      continue;
    const auto assembled = host::assemble(*each.shot->summary, each.shot->digitizations.back().frame,
                                          host::assembly_settings(each.session->rig));
    for (const ContactPoint& p : contact_points(assembled.frame, readout)) {
      data::ContactRow row{1e3 * p.time_s / *dwell_ms,
                           1e2 * p.x_m / *distance_cm,
                           p.drop_m / each.session->rig.ball.diameter_m,
                           {}};
      if (p.rotation_rad && std::abs(total_rotation_rad) > 1e-6)
        row.rotation_fraction = *p.rotation_rad / total_rotation_rad;
      out.set.rows.push_back(row);
      ++out.images;
    }
  }
  out.set.rows.push_back({1.0, 1.0, 0.0, 1.0});
  std::stable_sort(
      out.set.rows.begin(), out.set.rows.end(),
      [](const data::ContactRow& a, const data::ContactRow& b) { return a.time_fraction < b.time_fraction; });
  return out;
}

/// The thesis's inputs with this condition in the place of its own one.
thesis::ThesisInputs with(const thesis::ThesisInputs& thesis, const thesis::Condition& own,
                          data::ContactSet set) {
  thesis::ThesisInputs inputs = thesis;
  auto& conditions = inputs.used.conditions;
  const auto same = std::ranges::find(conditions, own.name(), &thesis::Condition::name);
  if (same == conditions.end()) {
    conditions.push_back(own);
  } else {
    *same = own;
  }
  inputs.used.contact[own.name()] = std::move(set);
  return inputs;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
  return text;
}

/// Figures say "printed" of what is here measured.
std::string own_words(const std::string& text) {
  return replaced(replaced(text, "printed sd", "scatter sd"), "printed means", "means");
}

Chart chart_of(figures::Figure figure, const std::string& key) {
  const int number = figure.number;
  figure.title = fmt::format("As the thesis's Figure {}: {}", number, own_words(figure.title));
  figure.caption = own_words(figure.caption);
  for (figures::Panel& panel : figure.panels)
    for (figures::Series& series : panel.series) series.legend = own_words(series.legend);
  return make_chart(fmt::format("figure_{}_{}", number, key), std::move(figure));
}

void add(Section& section, const ConditionGroup& group, const ReportInput& input, bool all) {
  const auto own = condition_of(group);
  if (!own) return;
  auto inputs = with(*input.thesis, *own, {own->name(), {}});
  ContactImages images = images_of(group, thesis::contact_scale(inputs, *own).total_rotation_rad);
  if (images.images < kMinImages) return;
  inputs.used.contact[own->name()] = std::move(images.set);
  auto figures = thesis::make_figures(inputs, {own->name()});
  if (!figures) return;
  section.blocks.emplace_back(Paragraph{
      "images_" + group.key,
      fmt::format("{}: {} images in contact of {} shots.", group.label, images.images, group.counted.size()),
      false, true});
  const std::set<int> essential{4, 5, 6, 13, 16};
  for (figures::Figure& figure : *figures)
    if (all || essential.contains(figure.number))
      section.blocks.emplace_back(chart_of(std::move(figure), group.key));
}

}  // namespace

std::vector<ContactPoint> contact_points(const reduction::Frame& frame, const reduction::Readout& readout) {
  if (frame.images.empty() || reduction::validation_error(frame)) return {};
  reduction::FlagSet flags;
  const auto all = reduction::observe(frame, flags);
  const auto td = all ? touchdown(*all, readout) : std::nullopt;
  if (!td) return {};
  std::vector<ContactPoint> points;
  for (std::size_t i = 0; i < all->images.size(); ++i) {
    const Observation& observed = all->images[i];
    const reduction::BallImage& image = frame.images[i];
    const double since_s = observed.time_s - td->time_s;
    if (!image.top_px || since_s <= 0.0 || since_s >= td->dwell_s) continue;
    const Eigen::Vector2d top = all->surface.from_image({image.top_px->x, image.top_px->y});
    points.push_back({since_s, observed.centre_m.x() - td->x_m, top.y() - all->ball_diameter_m,
                      rotation_rad(*td, image, observed, since_s)});
  }
  return points;
}

Section contact_figures(const Content& content) {
  Section section{"contact", "Images in contact"};
  if (!content.input.thesis) return section;
  const bool all = content.input.all || content.conditions.size() == 1;
  for (std::size_t i = 0; i < content.conditions.size(); ++i) {
    if (content.input.progress) content.input.progress(i, content.conditions.size(), "images in contact");
    add(section, content.conditions[i], content.input, all);
  }
  if (!section.blocks.empty())
    section.blocks.insert(
        section.blocks.begin(),
        Paragraph{
            "meaning",
            "Images in contact since touchdown, of all shots of a condition, as fractions of each shot's own "
            "contact; the contact mechanics are those fitted to the thesis's 21 conditions."});
  return section;
}

}  // namespace strobe::report
