#include "sim/loading/inheritance.hpp"
#include "sim/loading/parse_scene.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "sim/loading/tables.hpp"

namespace strobe::sim {

namespace {

using config::TomlReader;
using config::TomlTable;

struct Key {
  std::string_view table;  ///< "": the root
  std::string_view key;
};

/// One of several alternatives: the keys that select it, and those that are valid only with it.
struct Way {
  std::vector<Key> choosing;
  std::vector<Key> beside{};
};

const std::vector<std::vector<Way>>& alternatives() {
  static const std::vector<std::vector<Way>> all{
      {{{{"bounce", "e"}, {"bounce", "dwell_ms"}}, {{"bounce", "e_slope_s_per_m"}}},
       {{{"ball", "stiffness_npm"}, {"ball", "damping_nspm"}}}},
      {{{{"bounce", "mu"}}},
       {{{"surface", "friction"}}},
       {{{"surface", "court_pace"}}},
       {{{"surface", "pace_grade"}}}},
      {{{{"ball", "alpha"}}}, {{{"ball", "inertia"}}}},
      {{{{"", "surface_angle_deg"}}}, {{{"surface", "tilt_deg"}}}},
  };
  return all;
}

std::vector<Key> keys_of(std::string_view law) {
  std::vector<Key> keys;
  for (const std::string_view key : tables::keys_of(law == "grip" ? ContactLaw::grip : ContactLaw::ode))
    keys.push_back({"bounce", key});
  return keys;
}

bool has(TomlReader& document, const Key& key) {
  TomlTable root = document.root();
  return key.table.empty() ? root.has(key.key)
                           : root.is_table(key.table) && root.table(key.table).has(key.key);
}

bool has_any(TomlReader& document, const std::vector<Key>& keys) {
  return std::ranges::any_of(keys, [&](const Key& key) { return has(document, key); });
}

void drop(TomlReader& document, const std::vector<Key>& keys) {
  for (const Key& key : keys) document.remove(key.table, key.key);
}

std::string law_of(TomlReader& document) {
  TomlTable root = document.root();
  if (!has(document, {"bounce", "contact"}) || !root.table("bounce").is_string("contact")) return "ode";
  return root.table("bounce").string("contact");
}

/// Removes from the parent the alternatives that the child replaces.
void drop_overridden(TomlReader& child, TomlReader& parent) {
  for (const std::vector<Way>& ways : alternatives()) {
    for (const Way& chosen : ways) {
      if (!has_any(child, chosen.choosing)) continue;
      for (const Way& other : ways) {
        if (&other == &chosen) continue;
        drop(parent, other.choosing);
        drop(parent, other.beside);
      }
    }
  }
  if (has(child, {"bounce", "contact"}) && law_of(child) != law_of(parent))
    drop(parent, keys_of(law_of(parent)));
}

class Chain {
 public:
  explicit Chain(const SceneResolver& resolve) : resolve_(resolve) {}

  Result<TomlReader> merge(TomlReader child, const std::string& file_name) {
    files_.push_back(file_name);
    TomlTable root = child.root();
    if (!root.has("inherits")) return child;
    const std::string parent_name = root.string("inherits");
    if (auto bad = child.error_so_far()) return tl::unexpected(*bad);
    auto parent = parent_of(parent_name, file_name);
    if (!parent) return refused(child, root, parent.error().message);
    TomlReader document(parent->text, parent->file_name);
    if (auto bad = document.error_so_far()) return tl::unexpected(*bad);
    auto whole = merge(std::move(document), parent->file_name);
    if (!whole) return whole;
    drop_overridden(child, *whole);
    child.inherit(std::move(*whole));
    return child;
  }

 private:
  Result<SceneText> parent_of(const std::string& name, const std::string& file_name) const {
    if (!resolve_) return fail("no other scenes can be read here");
    if (files_.size() > kMaxAncestors)
      return fail("more than " + std::to_string(kMaxAncestors) + " scenes inherit from each other");
    auto parent = resolve_(name, file_name);
    if (parent && std::ranges::find(files_, parent->file_name) != files_.end())
      return fail(parent->file_name + " inherits from itself");
    return parent;
  }

  static Result<TomlReader> refused(TomlReader& child, TomlTable& root, const std::string& what) {
    root.error_at("inherits", what);
    return tl::unexpected(*child.error_so_far());
  }

  const SceneResolver& resolve_;
  std::vector<std::string> files_;
};

}  // namespace

Result<TomlReader> with_inherited(TomlReader child, const std::string& file_name,
                                  const SceneResolver& resolve) {
  if (auto bad = child.error_so_far()) return tl::unexpected(*bad);
  return Chain(resolve).merge(std::move(child), file_name);
}

}  // namespace strobe::sim
