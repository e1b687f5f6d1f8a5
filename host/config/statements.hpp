// What a laboratory states of itself and of a job, for a report: the rig file's [laboratory] and [report]. Text on one
// line each; strobed and the analysis do not use it. Constants and pure functions; thread-safe.
// Source: ISO/IEC 17025:2017, 7.8.2 and 7.8.3.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "common/config/toml_reader.hpp"

namespace strobe::host {

struct StatementKey {
  std::string_view id;          ///< in JSON; as an option with - for _
  std::string_view table, key;  ///< in the rig file
  std::string_view label;
  std::string_view example;
};

inline constexpr std::array<StatementKey, 20> kStatementKeys{{
    {"title", "report", "title", "Title", "Test report: impact of a ball on a surface"},
    {"laboratory", "laboratory", "name", "Laboratory", "Sports Surfaces Laboratory"},
    {"address", "laboratory", "address", "Address", "1 Main Street, Springfield"},
    {"contact", "laboratory", "contact", "Contact", "lab@example.org"},
    {"location", "laboratory", "location", "Place of the tests", "hall 2"},
    {"accreditation", "laboratory", "accreditation", "Accreditation", "none"},
    {"customer", "report", "customer", "Customer", "Courts Ltd."},
    {"customer_contact", "report", "customer_contact", "Customer's contact", "2 Main Street, Springfield"},
    {"item", "report", "item", "Item tested", "sample 17, acrylic hard court, 600 x 600 mm"},
    {"item_condition", "report", "item_condition", "Condition of the item", "new, clean, dry"},
    {"received", "report", "received", "Date of receipt", "2026-11-02"},
    {"sampling", "report", "sampling", "Sampling", "by the customer"},
    {"method", "report", "method", "Method", "ITF CS 01/02"},
    {"deviations", "report", "deviations", "Deviations from the method", "none"},
    {"conditions", "report", "conditions", "Environmental conditions", "21 C, 45 % relative humidity"},
    {"tested_by", "report", "tested_by", "Operator", "J. Smith"},
    {"authorised_by", "report", "authorised_by", "Authorised by", "A. Jones"},
    {"authorised_role", "report", "authorised_role", "Role", "head of laboratory"},
    {"issued", "report", "issued", "Date of issue", "2026-11-21"},
    {"remarks", "report", "remarks", "Remarks", "the ball was changed after shot 6"},
}};

/// By StatementKey::id; what is not stated is absent.
using Statements = std::map<std::string, std::string>;

/// What is wrong with a statement, or nothing: text of at most 1024 bytes on one line; `received` and `issued` are days as
/// 2026-11-21.
std::optional<std::string> statement_problem(const StatementKey& key, const std::string& text);

/// Reads both tables; what is wrong is reported to the document's reader. Empty texts state nothing.
Statements read_statements(config::TomlTable root);

}  // namespace strobe::host
