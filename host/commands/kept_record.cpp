#include "host/commands/kept_record.hpp"

#include "common/config/files.hpp"
#include "host/commission/all_steps.hpp"
#include "host/commission/record/record.hpp"

namespace strobe::host {

namespace fs = std::filesystem;

Result<std::string> keep_commission_record(const fs::path& rig_path, const RigFile& rig,
                                           const fs::path& session, WallTime now) {
  if (rig_path.empty()) return std::string();
  const fs::path path = commission::record_path(rig_path, rig.commission);
  commission::Record record;
  std::error_code error;
  const auto text = config::read_file_if_any(path);
  if (!text) return tl::unexpected(text.error());
  if (*text) {
    record = commission::parse_record(**text);
    const fs::path copy = session / commission::kRecordInSession;
    const bool same = fs::exists(copy, error) && config::read_file(copy.string()) == **text;
    if (!same)
      if (auto written = config::write_file(copy, **text); !written) return tl::unexpected(written.error());
  }
  const auto stands = commission::standing(record, commission::all_infos(), rig, now);
  if (stands.state == commission::Standing::State::good) return std::string();
  return "the rig is " + stands.words + " (see strobe commission)";
}

}  // namespace strobe::host
