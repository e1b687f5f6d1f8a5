// Inside common, firmware, host and sim, folders are layers: each includes lower ones only. No cycle anywhere.
#include <fmt/format.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>
#include "tests/support/string_from.hpp"

#include "tests/structure/folder_graph.hpp"

namespace {

using namespace strobe::structure;

/// Folders of one layer do not include each other.
using Layer = std::set<std::string>;

/// Lowest first. A new folder is put as low as its includes allow.
const std::map<std::string, std::vector<Layer>> kLayers{
    {"common",
     {
         {"common", "common/impact"},
         {"common/authentication", "common/ball", "common/command_line", "common/config", "common/image", "common/sampling", "common/statistics", "common/units", "common/wire"},
         {"common/data", "common/flight", "common/impact/closed_form", "common/shot"},
         {"common/geometry", "common/impact/ode"},
         {"common/contact/integration", "common/impact/fit", "common/reduction"},
         {"common/contact/differentiation", "common/messages", "common/reduction/matching"},
         {"common/contact"},
     }},
    {"firmware",
     {
         {"firmware/ports"},
         {"firmware/core"},
         {"firmware/gpio"},
         {"firmware/linux", "firmware/publisher"},
         {"firmware"},
     }},
    {"host",
     {
         {"host/clock", "host/config", "host/digitize/core", "host/digitize/image", "host/external",
          "host/figures", "host/web/http"},
         {"host/assembly", "host/camera", "host/digitize/candidates", "host/digitize/equator",
          "host/digitize/outline", "host/digitize/surface", "host/digitize/transfer", "host/messages"},
         {"host/bounces", "host/digitize/path", "host/session"},
         {"host/digitize/outliers", "host/export"},
         {"host/digitize"},
         {"host/report/model"},
         {"host/photographs", "host/report/html"},
         {"host/loop"},
         {"host/archive", "host/commission/core"},
         {"host/batch", "host/commission/camera", "host/commission/electrical", "host/commission/record",
          "host/series"},
         {"host/commission/balls", "host/view"},
         {"host/commission", "host/thesis"},
         {"host/report/content", "host/web/commission", "host/web/json"},
         {"host/report/sections", "host/web/live"},
         {"host/report"},
         {"host/web/archive"},
         {"host/web/editing"},
         {"host/commands"},
         {"host/commands/report", "host/commands/series"},
         {"host"},
     }},
    {"sim",
     {
         {"sim/gpiochip", "sim/random", "sim/scene"},
         {"sim/gpiochip/preload", "sim/motion"},
         {"sim/loading", "sim/rig"},
         {"sim/fit", "sim/photograph", "sim/shoot"},
         {"sim/effects", "sim/live", "sim/rig_file"},
         {"sim/commands"},
         {"sim"},
     }},
};

std::optional<std::size_t> layer_of(const std::string& folder) {
  const auto layers = kLayers.find(top_folder(folder));
  if (layers == kLayers.end()) return std::nullopt;
  for (std::size_t i = 0; i < layers->second.size(); ++i)
    if (layers->second[i].contains(folder)) return i;
  return std::nullopt;
}

std::set<std::string> folders_with_code() {
  std::set<std::string> folders;
  for (const SourceFile& file : cpp_files()) folders.insert(folder_of(file.path));
  return folders;
}

std::string text_of(const FolderInclude& include) {
  return fmt::format("\n  {}:{}: {}", include.file, include.line, include.target);
}

}  // namespace

TEST_GROUP(Layers){};

TEST(Layers, KnowEveryFolderAndNoOther) {
  const std::set<std::string> folders = folders_with_code();
  std::string wrong;
  for (const std::string& folder : folders)
    if (kLayers.contains(top_folder(folder)) && !layer_of(folder)) wrong += "\n  in no layer: " + folder;
  for (const auto& [top, layers] : kLayers) {
    for (const Layer& layer : layers) {
      for (const std::string& folder : layer)
        if (!folders.contains(folder)) wrong += "\n  no such folder: " + folder;
    }
  }
  CHECK_EQUAL("", wrong);
}

TEST(Layers, IncludeOnlyLowerOnes) {
  std::string wrong;
  for (const FolderInclude& include : includes_between_folders(cpp_files())) {
    if (top_folder(include.from) != top_folder(include.to)) continue;  // IncludeGraph's
    const auto from = layer_of(include.from), to = layer_of(include.to);
    if (from && to && *to >= *from) wrong += text_of(include);
  }
  CHECK_EQUAL("", wrong);
}

TEST(Layers, FormNoCycleInProductAndTests) {
  std::string wrong;
  for (const auto& cycle : cycles(includes_between_folders(cpp_files()))) {
    wrong += "\ncycle:";
    for (const FolderInclude& include : cycle) wrong += text_of(include);
  }
  CHECK_EQUAL("", wrong);
}
