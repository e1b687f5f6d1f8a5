#include "common/config/toml_reader.hpp"

// Without it a debug build ends where a person's file has [[ >]]: the parser asserts what it reports next.
#define TOML_ASSERT(expr) static_assert(true)
#include <toml++/toml.h>

#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "common/config/nearest.hpp"
#include "common/config/toml_bounds.hpp"

namespace strobe::config {

namespace {

/// Keys, values and the parser's own words may hold line breaks; a message is one line.
std::string on_one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

}  // namespace

struct TomlReader::State {
  std::string file_name;
  toml::table document;
  std::optional<Error> first_error;
  bool something_lacks = false;  ///< that error is of a key or table that is not there
  std::set<const toml::node*> asked;
  std::map<const toml::table*, std::vector<std::string>> known;  ///< keys that were asked for, there or not

  /// What was inherited stands in its own file.
  std::string place(const toml::source_region& source) const {
    const std::string& file = source.path ? *source.path : file_name;
    return source.begin.line > 0 ? file + ":" + std::to_string(source.begin.line) : file;
  }

  void report(const toml::source_region& source, const std::string& path, const std::string& what,
              bool lacks = false) {
    if (first_error) return;
    something_lacks = lacks;
    first_error = Error{on_one_line(place(source) + ": " + (path.empty() ? "" : path + ": ") + what)};
  }
};

struct TomlTable::Node {
  std::shared_ptr<TomlReader::State> state;
  const toml::table* table = nullptr;  // null: absent
  std::string path;

  std::string path_of(std::string_view key) const {
    if (key.empty()) return path;
    return path.empty() ? std::string(key) : path + "." + std::string(key);
  }
  const toml::node* find(std::string_view key) const {
    const toml::node* node = table ? table->get(key) : nullptr;
    if (table) state->known[table].emplace_back(key);
    if (node) state->asked.insert(node);
    return node;
  }
  toml::source_region source() const { return table ? table->source() : toml::source_region{}; }
  std::uint32_t line() const { return source().begin.line; }
  void report(std::string_view key, const toml::node* node, const std::string& what) {
    state->report(node ? node->source() : source(), path_of(key), what, node == nullptr);
  }
};

namespace {

std::string shortest(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::optional<std::string> outside(double value, Range range) {
  if (!std::isfinite(value)) return "must be a finite number";
  if (value < range.least) return "must be at least " + shortest(range.least) + ", is " + shortest(value);
  if (value > range.most) return "must be at most " + shortest(range.most) + ", is " + shortest(value);
  return std::nullopt;
}

}  // namespace

bool TomlTable::present() const { return node_->table != nullptr; }
bool TomlTable::has(std::string_view key) const {
  if (!node_->table) return false;
  node_->state->known[node_->table].emplace_back(key);
  return node_->table->contains(key);
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  if (node_->table) {
    for (const auto& [key, value] : *node_->table) names.emplace_back(key.str());
  }
  return names;
}

TomlTable TomlTable::table(std::string_view key) {
  auto child = std::make_shared<Node>();
  child->state = node_->state;
  child->path = node_->path_of(key);
  const toml::node* node = node_->find(key);
  if (node) {
    child->table = node->as_table();
    if (!child->table) node_->report(key, node, "must be a table");
  }
  return TomlTable(child);
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  std::vector<TomlTable> result;
  const toml::node* node = node_->find(key);
  if (!node) return result;
  const toml::array* array = node->as_array();
  if (!array || (!array->empty() && !array->is_array_of_tables())) {
    node_->report(key, node, "must be an array of tables, written [[" + node_->path_of(key) + "]]");
    return result;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    auto child = std::make_shared<Node>();
    child->state = node_->state;
    child->path = node_->path_of(key) + "[" + std::to_string(i + 1) + "]";
    child->table = (*array)[i].as_table();
    node_->state->asked.insert(child->table);
    result.push_back(TomlTable(child));
  }
  return result;
}

std::optional<double> TomlTable::optional_number(std::string_view key, Range range) {
  const toml::node* node = node_->find(key);
  if (!node) return std::nullopt;
  if (!node->is_integer() && !node->is_floating_point()) {
    node_->report(key, node, "must be a number");
    return std::nullopt;
  }
  const double value = *node->value<double>();
  if (auto what = outside(value, range)) {
    node_->report(key, node, *what);
    return std::nullopt;
  }
  return value;
}

double TomlTable::number(std::string_view key, Range range) {
  if (!has(key)) node_->report(key, nullptr, "is missing");
  return optional_number(key, range).value_or(range.least > 0.0 ? range.least : 0.0);
}

double TomlTable::number_or(std::string_view key, double fallback, Range range) {
  return optional_number(key, range).value_or(fallback);
}

std::int64_t TomlTable::integer(std::string_view key, Range range) {
  if (!has(key)) node_->report(key, nullptr, "is missing");
  return integer_or(key, 0, range);
}

std::int64_t TomlTable::integer_or(std::string_view key, std::int64_t fallback, Range range) {
  const toml::node* node = node_->find(key);
  if (!node) return fallback;
  if (!node->is_integer()) {
    node_->report(key, node, "must be a whole number");
    return fallback;
  }
  const std::int64_t value = *node->value<std::int64_t>();
  if (auto what = outside(static_cast<double>(value), range)) {
    node_->report(key, node, *what);
    return fallback;
  }
  return value;
}

bool TomlTable::boolean_or(std::string_view key, bool fallback) {
  const toml::node* node = node_->find(key);
  if (!node) return fallback;
  if (!node->is_boolean()) {
    node_->report(key, node, "must be true or false");
    return fallback;
  }
  return *node->value<bool>();
}

std::string TomlTable::string(std::string_view key) {
  if (!has(key)) node_->report(key, nullptr, "is missing");
  return string_or(key, "");
}

std::string TomlTable::string_or(std::string_view key, std::string_view fallback) {
  const toml::node* node = node_->find(key);
  if (!node) return std::string(fallback);
  if (!node->is_string()) {
    node_->report(key, node, "must be text in quotes");
    return std::string(fallback);
  }
  return *node->value<std::string>();
}

std::string TomlTable::choice_or(std::string_view key, std::string_view fallback,
                                 const std::vector<std::string_view>& words) {
  const std::string value = string_or(key, fallback);
  std::string list;
  for (const std::string_view word : words) {
    if (word == value) return value;
    list += (list.empty() ? "" : ", ") + std::string(word);
  }
  error_at(key, "must be one of " + list + ", is \"" + value + "\"");
  return std::string(fallback);
}

std::vector<double> TomlTable::numbers_or(std::string_view key, const std::vector<double>& fallback,
                                          Range range) {
  const toml::node* node = node_->find(key);
  if (!node) return fallback;
  const toml::array* array = node->as_array();
  if (!array) {
    node_->report(key, node, "must be an array of numbers");
    return fallback;
  }
  std::vector<double> values;
  for (const toml::node& element : *array) {
    if (!element.is_integer() && !element.is_floating_point()) {
      node_->report(key, &element, "must be an array of numbers");
      return fallback;
    }
    values.push_back(*element.value<double>());
    if (auto what = outside(values.back(), range)) {
      node_->report(key, &element, *what);
      return fallback;
    }
  }
  return values;
}

std::vector<std::string> TomlTable::strings_or(std::string_view key,
                                               const std::vector<std::string>& fallback) {
  const toml::node* node = node_->find(key);
  if (!node) return fallback;
  const toml::array* array = node->as_array();
  if (!array || (!array->empty() && !array->is_homogeneous<std::string>())) {
    node_->report(key, node, "must be an array of texts in quotes");
    return fallback;
  }
  std::vector<std::string> texts;
  for (const toml::node& element : *array) texts.push_back(*element.value<std::string>());
  return texts;
}

bool TomlTable::is_boolean(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_boolean();
}

bool TomlTable::is_integer(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_integer();
}
bool TomlTable::is_string(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_string();
}
bool TomlTable::is_table(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_table();
}

std::uint32_t TomlTable::line_of(std::string_view key) const {
  const toml::node* node = node_->table ? node_->table->get(key) : nullptr;
  return node ? node->source().begin.line : node_->line();
}

namespace {

void mark_all(const toml::table& table, std::set<const toml::node*>& asked) {
  for (const auto& [key, node] : table) {
    asked.insert(&node);
    if (const toml::table* child = node.as_table()) mark_all(*child, asked);
  }
}

}  // namespace

void TomlTable::accept_all() const {
  if (node_->table) mark_all(*node_->table, node_->state->asked);
}

void TomlTable::error_at(std::string_view key, const std::string& what) {
  node_->report(key, node_->table ? node_->table->get(key) : nullptr, what);
}

TomlReader::TomlReader(std::string_view text, std::string file_name) : state_(std::make_shared<State>()) {
  state_->file_name = std::move(file_name);
  if (const auto problem = toml_bounds_problem(text)) {
    state_->first_error = Error{on_one_line(state_->file_name + ":" + problem->message)};
    return;
  }
  try {
    state_->document = toml::parse(text, state_->file_name);
  } catch (const toml::parse_error& error) {
    state_->report(error.source(), "", std::string(error.description()));
  }
}
TomlReader::~TomlReader() = default;
TomlReader::TomlReader(TomlReader&&) noexcept = default;
TomlReader& TomlReader::operator=(TomlReader&&) noexcept = default;

namespace {

/// Moves, since only moved nodes keep their place in the source.
void move_missing(toml::table& from, toml::table& to) {
  for (auto&& [key, node] : from) {
    toml::node* own = to.get(key.str());
    if (!own) {
      to.insert(key, std::move(node));
    } else if (own->is_table() && node.is_table()) {
      move_missing(*node.as_table(), *own->as_table());
    }
  }
}

}  // namespace

void TomlReader::inherit(TomlReader&& parent) {
  if (!state_->first_error) {
    state_->first_error = parent.state_->first_error;
    state_->something_lacks = parent.state_->something_lacks;
  }
  move_missing(parent.state_->document, state_->document);
}

void TomlReader::remove(std::string_view table, std::string_view key) {
  toml::node* node = table.empty() ? &state_->document : state_->document.get(table);
  toml::table* holder = node ? node->as_table() : nullptr;
  if (!holder) return;
  state_->asked.clear();  // of nodes that may be gone
  holder->erase(key);
}

TomlTable TomlReader::root() {
  auto node = std::make_shared<TomlTable::Node>();
  node->state = state_;
  node->table = &state_->document;
  return TomlTable(node);
}

namespace {

struct Unasked {
  toml::source_region source;
  std::string path;
  std::string key;
  const toml::table* table;
};

std::optional<Unasked> first_unasked(const toml::table& table, const std::set<const toml::node*>& asked,
                                     const std::string& path) {
  for (const auto& [key, node] : table) {
    const std::string full = path.empty() ? std::string(key.str()) : path + "." + std::string(key.str());
    if (!asked.contains(&node)) return Unasked{node.source(), full, std::string(key.str()), &table};
    if (const toml::table* child = node.as_table()) {
      if (auto found = first_unasked(*child, asked, full)) return found;
    }
    if (const toml::array* array = node.as_array()) {
      for (std::size_t i = 0; i < array->size(); ++i) {
        const toml::table* child = (*array)[i].as_table();
        if (!child || !asked.contains(child)) continue;
        if (auto found = first_unasked(*child, asked, full + "[" + std::to_string(i + 1) + "]")) return found;
      }
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Error> TomlReader::error_so_far() const { return state_->first_error; }

std::optional<Error> TomlReader::error() const {
  if (state_->first_error && !state_->something_lacks) return state_->first_error;
  if (auto found = first_unasked(state_->document, state_->asked, "")) {
    return Error{on_one_line(state_->place(found->source) + ": " + found->path + ": unknown key" +
                             did_you_mean(found->key, state_->known[found->table]))};
  }
  return state_->first_error;
}

}  // namespace strobe::config
