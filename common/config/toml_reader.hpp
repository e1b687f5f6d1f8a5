// Strict reading of TOML: every key is read by name, type and range; keys that were not read are errors.
// Errors read "FILE:LINE: table.key: what is wrong". No I/O of its own; thread-safe per object; allocates.
//
//   TomlReader reader(text, "rig.toml");
//   TomlTable strobe = reader.root().table("strobe");
//   rig.period_us = strobe.number("period_us", Range{1500, 1e6});      // required
//   rig.pulse_us = strobe.number_or("pulse_us", 50, Range{1, 1000});
//   if (auto bad = reader.error()) return fail(bad->message);          // first error, or an unknown key
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::config {

/// Inclusive limits; NaN and infinities are never within a range.
struct Range {
  double least = -std::numeric_limits<double>::max();
  double most = std::numeric_limits<double>::max();
};

class TomlReader;

/// A table of the document, or an absent one: reading an absent table gives the defaults, and for a required
/// key an error that names the table's path.
class TomlTable {
 public:
  bool present() const;
  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;

  TomlTable table(std::string_view key);                  ///< absent if there is none; error if not a table
  std::vector<TomlTable> tables(std::string_view key);    ///< array of tables, [[key]]; empty if absent
  double number(std::string_view key, Range range = {});  ///< integer or float
  double number_or(std::string_view key, double fallback, Range range = {});
  std::optional<double> optional_number(std::string_view key, Range range = {});
  std::int64_t integer(std::string_view key, Range range = {});
  std::int64_t integer_or(std::string_view key, std::int64_t fallback, Range range = {});
  bool boolean_or(std::string_view key, bool fallback);
  std::string string(std::string_view key);
  std::string string_or(std::string_view key, std::string_view fallback);
  /// One of the given words; the error lists them.
  std::string choice_or(std::string_view key, std::string_view fallback,
                        const std::vector<std::string_view>& words);
  std::vector<double> numbers_or(std::string_view key, const std::vector<double>& fallback, Range range = {});
  std::vector<std::string> strings_or(std::string_view key, const std::vector<std::string>& fallback);
  bool is_integer(std::string_view key) const;  ///< present and an integer
  bool is_string(std::string_view key) const;
  bool is_boolean(std::string_view key) const;
  bool is_table(std::string_view key) const;
  /// Line of the key's value in the file, from 1; the table's line if there is no such key; 0 if the table is
  /// absent.
  std::uint32_t line_of(std::string_view key) const;

  /// Accepts everything in this table unread: keys for other programs.
  void accept_all() const;

  /// Reports an error of the caller's own at the key's line (or at the table's, if there is no such key).
  void error_at(std::string_view key, const std::string& what);

 private:
  friend class TomlReader;
  struct Node;
  explicit TomlTable(std::shared_ptr<Node> node) : node_(std::move(node)) {}
  std::shared_ptr<Node> node_;
};

class TomlReader {
 public:
  /// Parses text; a syntax error, or that it is beyond toml_bounds.hpp, is kept and given by error().
  /// file_name is for messages only.
  TomlReader(std::string_view text, std::string file_name);
  ~TomlReader();
  TomlReader(TomlReader&&) noexcept;
  TomlReader& operator=(TomlReader&&) noexcept;

  /// Adds what `parent` has and this document lacks, table by table; arrays, also of tables, are added or not
  /// as a whole. Errors in what was added name the parent's file. What was read of this document stays read;
  /// TomlTables of the parent become invalid.
  void inherit(TomlReader&& parent);

  /// Removes a key from a table of the document's root ("": from the root itself), if it is there. Call it
  /// before reading: what was read so far counts as unread.
  void remove(std::string_view table, std::string_view key);

  TomlTable root();

  /// The first error so far: syntax, a value out of range or of another type. Then the first key of the
  /// document that was not read, even where something is missing: it may be that, misspelt. Then what is
  /// missing: a required key, or whatever error_at() says of a key that is not there. Call it last.
  std::optional<Error> error() const;

  /// The same without keys that were not read yet.
  std::optional<Error> error_so_far() const;

 private:
  friend class TomlTable;
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace strobe::config
