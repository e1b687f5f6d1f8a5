// What `strobe design` is asked, and what it works from. Reads files; single-threaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/design/improvements.hpp"
#include "host/series/sample_size.hpp"
#include "host/series/wanted.hpp"

namespace CLI {
class App;
}

namespace strobe::host {

struct DesignOptions {
  std::string rig_path, plan_path, spacing, like, scene, by = "digitizer", write_plan, figures;
  std::optional<double> speed_mps, angle_deg, spin_radps, e, mu, dwell_ms;
  std::optional<double> speed_sd_mps, angle_sd_deg, spin_sd_radps, e_sd, mu_sd, dwell_sd_ms;
  std::optional<double> px_per_m, scale_sd_percent, blur_px, exposure, flash_us, arrival_sd_ms;
  std::optional<double> focal_mm, distance_m, pixel_um;
  double f_number = 8.0;
  std::vector<std::string> wanted, differences;
  double power = kPower;
  int shots = 9, most_images = 0;
  bool search = false, all = false, json = false;
};

struct DesignInputs {
  RigFile rig;
  Design design;
  std::string train_remark;  ///< how the plan is coded, for a person
  std::vector<Wanted> wanted, differences;
  double power = kPower;
  bool search = false;
  int most_images = 0;
};

void add_design_options(CLI::App& command, DesignOptions& options);

/// Fails naming the option, file or key.
Result<DesignInputs> design_inputs(const DesignOptions& options);

}  // namespace strobe::host
