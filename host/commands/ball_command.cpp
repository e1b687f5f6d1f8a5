// strobe ball: kinds of balls, what their files say and where it was read.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/data/ball_kind.hpp"
#include "common/messages/air_law_json.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/text/text.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

struct BallOptions {
  std::vector<std::string> names;
  bool json = false;
};

std::string read_in(const std::string& source) { return source.empty() ? "assumed" : source; }

/// What can be measured of its spin.
std::string spin_of(balls::Marking marking) {
  if (marking == balls::Marking::line) return "measured, from the drawn line";
  if (marking == balls::Marking::plain) return "not measured: nothing on it turns; draw a line";
  return fmt::format("not measured from its {}: draw a line", balls::name(marking));
}

ordered_json sourced_json(const balls::Sourced& number) {
  return {{"value", number.value}, {"sd", number.sd}, {"source", number.source}};
}

ordered_json ball_json(const balls::Kind& kind) {
  ordered_json out{{"ball", kind.name},
                   {"title", kind.title},
                   {"diameter_m", sourced_json(kind.diameter_m)},
                   {"mass_kg", sourced_json(kind.mass_kg)},
                   {"alpha", sourced_json(kind.alpha)}};
  out["air"] = messages::air_law_json(kind.air);
  out["air"]["source"] = kind.air_source;
  if (const auto& e = kind.elasticity)
    out["elasticity"] = {{"per_K", e->per_K},
                         {"per_K_sd", e->per_K_sd},
                         {"reference_degC", e->reference_degC},
                         {"source", e->source}};
  const balls::ContactRange& c = kind.contact;
  out["contact"] = {{"least_normal_mps", c.least_normal_mps},
                    {"most_normal_mps", c.most_normal_mps},
                    {"dwell_s", c.dwell_s},
                    {"e", c.e},
                    {"mu", c.mu},
                    {"source", c.source}};
  out["marking"] = balls::name(kind.marking);
  out["spin"] = spin_of(kind.marking);
  out["remarks"] = kind.remarks;
  return out;
}

std::vector<std::string> ball_lines(const balls::Kind& kind) {
  const flight::AirLaw& air = kind.air;
  const balls::ContactRange& c = kind.contact;
  std::vector<std::string> lines{fmt::format("{}: {}", kind.name, kind.title)};
  const auto tell = [&lines](const std::string& what, const std::string& source) {
    for (std::string& part : wrapped(fmt::format("  {} [{}]", what, read_in(source)), kPlainWidth, "    "))
      lines.push_back(std::move(part));
  };
  const auto of = [](const balls::Sourced& n, double unit, const char* name) {
    return fmt::format("{:.4g} ± {:.2g}{}", unit * n.value, unit * n.sd, name);
  };
  tell("diameter " + of(kind.diameter_m, 1e3, " mm"), kind.diameter_m.source);
  tell("mass " + of(kind.mass_kg, 1e3, " g"), kind.mass_kg.source);
  tell("moment of inertia over m R^2 " + of(kind.alpha, 1.0, ""), kind.alpha.source);
  const std::string lift = air.lift_offset > 0.0
                               ? fmt::format("C_L S/({:g} + {:g} S) ± {:.0f} %, S = R omega/v",
                                             air.lift_offset, air.lift_slope, 100.0 * air.lift_share_sd)
                               : "no lift";
  tell(fmt::format("air, at {:g} to {:g} m/s: C_D {:g} ± {:g}; {}; spin lost {:g} ± {:g} per m",
                   air.least_mps, air.most_mps, air.drag_coefficient, air.drag_coefficient_sd, lift,
                   air.spin_decay_per_m, air.spin_decay_sd_per_m),
       kind.air_source);
  tell(fmt::format(
           "bounce, at {:g} to {:g} m/s normal to the surface: about e {:g}, mu {:g}, {:g} ms in contact",
           c.least_normal_mps, c.most_normal_mps, c.e, c.mu, 1e3 * c.dwell_s),
       c.source);
  if (const auto& e = kind.elasticity)
    tell(fmt::format("e changes by {:g} ± {:g} per kelvin, about {:g} degrees C", e->per_K, e->per_K_sd,
                     e->reference_degC),
         e->source);
  else
    lines.push_back("  how e changes with temperature is not known");
  lines.push_back("  spin: " + spin_of(kind.marking));
  for (const std::string& remark : kind.remarks)
    for (std::string& part : wrapped("  remark: " + remark, kPlainWidth, "    "))
      lines.push_back(std::move(part));
  return lines;
}

/// One line a kind, if none is named.
std::string listed(const balls::Kind& kind) {
  return fmt::format("{:<13} {:6.1f} mm {:7.1f} g   C_D {:<5g} {:<9} {}", kind.name,
                     1e3 * kind.diameter_m.value, 1e3 * kind.mass_kg.value, kind.air.drag_coefficient,
                     balls::name(kind.marking), kind.title);
}

int run_ball(const BallOptions& options) {
  std::vector<std::string> names = options.names;
  if (names.empty()) {
    auto all = balls::shipped_ball_kinds();
    if (!all) return bad_input("ball: " + all.error().message);
    names = *std::move(all);
  }
  std::vector<balls::Kind> kinds;
  for (const std::string& name : names) {
    auto kind = balls::load_ball_kind(name);
    if (!kind) return bad_input("ball: " + kind.error().message);
    kinds.push_back(*std::move(kind));
  }
  for (const balls::Kind& kind : kinds) {
    if (options.json)
      std::printf("%s\n", messages::json_text(ball_json(kind)).c_str());
    else
      print(options.names.empty() ? std::vector{listed(kind)} : ball_lines(kind));
  }
  return kDone;
}

}  // namespace

void add_ball_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<BallOptions>();
  CLI::App* command = app.add_subcommand("ball", "Kinds of balls, and where their numbers are from");
  command->add_option("NAME", options->names,
                      "Shipped kinds, or ball files that end in .toml (default: all)");
  command->add_flag("--json", options->json, "One JSON object a ball");
  command->footer(
      "Example: strobe ball golf\n"
      "A rig file's [ball] kind, a scene's, and --ball of other commands take the same names.");
  command->callback([options, &exit_status] { exit_status = run_ball(*options); });
}

}  // namespace strobe::host
