#include "host/design/promise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/config/files.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"
#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

std::optional<double> number_at(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// Absent: it is none.
std::optional<PredictedQuantity> quantity_from(const ordered_json& object) {
  const auto mean = number_at(object, "expected"), spread = number_at(object, "spread"),
             shot_sd = number_at(object, "shot_sd"), shared_sd = number_at(object, "shared_sd");
  if (!mean || !spread || !shot_sd || !shared_sd) return std::nullopt;
  if (!(*spread >= 0.0 && *shot_sd >= 0.0 && *shared_sd >= 0.0 && *shared_sd <= *shot_sd))
    return std::nullopt;
  PredictedQuantity q;
  q.mean = *mean;
  q.spread = *spread;
  q.shot_sd = *shot_sd;
  q.shared_sd = *shared_sd;
  return q;
}

/// Root mean square of what the shots that count state; 0: none does.
double stated_sd(std::span<const Shot> shots, Quantity q) {
  double squares = 0.0;
  int n = 0;
  for (const Shot& shot : shots) {
    const auto sd = reduction::total_sd(shot.readout, q);
    if (shot.rejected || !sd) continue;
    squares += *sd * *sd;
    ++n;
  }
  return n > 0 ? std::sqrt(squares / n) : 0.0;
}

std::string pair_cells(double promised, double became) {
  return right(rounded(promised, promised), kNumberWidth) + right(rounded(became, promised), kNumberWidth);
}

}  // namespace

Result<Promise> parse_promise(std::string_view text, const std::string& file) {
  const auto json = ordered_json::parse(text, nullptr, false);
  const auto quantities = json.is_object() ? json.find("quantities") : json.end();
  if (json.is_discarded() || !json.is_object() || quantities == json.end() || !quantities->is_object())
    return fail(file + ": not what strobe design --json prints");
  Promise promise;
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    const auto found = quantities->find(std::string(reduction::kQuantityNames[q]));
    if (found == quantities->end()) continue;
    promise[q] = found->is_object() ? quantity_from(*found) : std::nullopt;
    if (!promise[q])
      return fail(fmt::format("{}: quantities.{}: not what strobe design --json prints", file,
                              reduction::kQuantityNames[q]));
  }
  return promise;
}

Result<std::optional<Promise>> promise_of(const std::filesystem::path& session) {
  const std::filesystem::path path = session / kDesignFile;
  const auto text = config::read_file_if_any(path);
  if (!text) return tl::unexpected(text.error());
  if (!*text) return std::nullopt;
  return parse_promise(**text, path.string());
}

std::vector<Kept> kept(const Promise& promise, const SeriesSummary& summary, std::span<const Shot> shots) {
  std::vector<Kept> list;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const QuantitySummary& s = summary.quantities[i];
    if (!promise[i] || s.n < 2 || !s.scatter_sd) continue;
    const PredictedQuantity& p = *promise[i];
    Kept k;
    k.quantity = static_cast<Quantity>(i);
    k.n = s.n;
    k.promised_sd = p.shot_sd;
    k.shot_sd = stated_sd(shots, k.quantity);
    k.promised_scatter = p.scatter_sd();
    k.scatter = *s.scatter_sd;
    k.promised_expanded = p.expanded(s.n);
    k.expanded = s.expanded_uncertainty.value_or(0.0);
    k.sd_missed = k.shot_sd > kPromiseMargin * k.promised_sd;
    list.push_back(k);
  }
  for (Kept& k : list) {
    // One chance for each quantity (Bonferroni).
    const double level = kPromiseLevel / static_cast<double>(list.size());
    const double ratio = k.scatter / k.promised_scatter;
    k.scatter_missed =
        k.scatter > 0.0 && (!(k.promised_scatter > 0.0) ||
                            statistics::chi_squared_tail((k.n - 1) * ratio * ratio, k.n - 1.0) < level);
  }
  return list;
}

std::vector<std::string> render_kept(const std::vector<Kept>& list, std::size_t width) {
  if (list.empty()) return {};
  const auto pair = [](std::string_view name) { return right(name, 2 * kNumberWidth); };
  std::vector<std::string> lines{left("promised, became", kNameWidth) + left("unit", kUnitWidth) +
                                 pair("one shot's u") + pair("scatter") + pair("mean ± 95 %")};
  for (const Kept& k : list) {
    if (!is_essential(k.quantity)) continue;
    const QuantityLabel& label = kQuantityLabels[static_cast<std::size_t>(k.quantity)];
    std::string line = left(label.words, kNameWidth) + left(label.unit, kUnitWidth) +
                       pair_cells(k.promised_sd, k.shot_sd) + pair_cells(k.promised_scatter, k.scatter) +
                       pair_cells(k.promised_expanded, k.expanded);
    if (k.scatter_missed) line += "  ! scatters more than chance allows";
    if (k.sd_missed) line += "  ! shots are less certain";
    lines.push_back(std::move(line));
  }
  return fitted(std::move(lines), width);
}

ordered_json kept_json(const std::vector<Kept>& list) {
  ordered_json out = ordered_json::object();
  for (const Kept& k : list)
    out[std::string(reduction::name(k.quantity))] = {{"shots", k.n},
                                                     {"promised_shot_sd", k.promised_sd},
                                                     {"shot_sd", k.shot_sd},
                                                     {"promised_scatter_sd", k.promised_scatter},
                                                     {"scatter_sd", k.scatter},
                                                     {"promised_expanded_uncertainty", k.promised_expanded},
                                                     {"expanded_uncertainty", k.expanded},
                                                     {"scatter_missed", k.scatter_missed},
                                                     {"sd_missed", k.sd_missed}};
  return out;
}

}  // namespace strobe::host
