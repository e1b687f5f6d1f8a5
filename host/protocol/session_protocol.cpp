#include "host/protocol/session_protocol.hpp"

#include "common/config/files.hpp"
#include "host/session/run_record.hpp"

namespace strobe::protocol {

Result<std::optional<SessionProtocol>> protocol_of_session(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kProtocolFile;
  const auto text = config::read_file_if_any(file);
  if (!text) return tl::unexpected(text.error());
  if (!*text) return std::nullopt;
  auto protocol = read_protocol(**text, file.string());
  if (!protocol) return tl::unexpected(protocol.error());
  const auto runs = host::read_runs(folder / "runs.jsonl");
  if (!runs) return tl::unexpected(runs.error());
  SessionProtocol found{std::move(*protocol), **text, 0};
  for (const host::RunRecord& run : runs->runs) {
    if (run.protocol.empty()) continue;
    found.protocol.name = run.protocol;
    found.seed = static_cast<std::uint64_t>(run.protocol_seed);
  }
  return found;
}

}  // namespace strobe::protocol
