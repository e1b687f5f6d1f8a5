#include "tests/structure/folder_graph.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::structure;

namespace {

FolderInclude include(const std::string& from, const std::string& to) {
  return {from, to, from + "/a.cpp", 1, to + "/b.hpp"};
}

}  // namespace

TEST_GROUP(FolderGraph){};

TEST(FolderGraph, HasAnEdgeForEachQuotedIncludeOfAnotherFolder) {
  const SourceFile file{
      "host/session/a.cpp",
      {"#include <vector>", "#include \"host/session/a.hpp\"", "  # include \"common/b.hpp\""}};
  const auto found = includes_between_folders({file});
  LONGS_EQUAL(1, found.size());
  CHECK_EQUAL("host/session", found[0].from);
  CHECK_EQUAL("common", found[0].to);
  LONGS_EQUAL(3, found[0].line);
}

TEST(FolderGraph, WithoutACycleHasNoneToName) {
  LONGS_EQUAL(0, cycles({include("a", "b"), include("a", "c"), include("b", "c")}).size());
}

TEST(FolderGraph, NamesTheIncludesOfEachCycleAndNoOthers) {
  const auto found = cycles({include("top", "a"), include("a", "b"), include("b", "c"), include("c", "a"),
                             include("c", "base"), include("x", "y"), include("y", "x"), include("x", "a")});
  LONGS_EQUAL(2, found.size());
  LONGS_EQUAL(3, found[0].size());
  CHECK_EQUAL("a", found[0][0].from);
  LONGS_EQUAL(2, found[1].size());
}

TEST(FolderGraph, JoinsCyclesThatShareAFolder) {
  const auto found = cycles({include("a", "b"), include("b", "a"), include("b", "c"), include("c", "b")});
  LONGS_EQUAL(1, found.size());
  LONGS_EQUAL(4, found[0].size());
}
