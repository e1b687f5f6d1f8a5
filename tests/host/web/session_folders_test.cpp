#include "host/web/session_folders.hpp"

#include <rapidcheck.h>

#include "host/web/bounded_cache.hpp"
#include "host/web/http/message.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
namespace fs = std::filesystem;

}  // namespace

TEST_GROUP(SessionFolders) {
  testing::TemporaryFolder place;
  fs::path sessions = place / "sessions";

  void setup() override {
    fs::create_directories(sessions / "today" / "photographs");
    testing::write_text(sessions / "today" / "results.csv", "utc\n");
    testing::write_text(sessions / "today" / "photographs" / "a.tif", "a");
    fs::create_directories(place / "other");
    testing::write_text(place / "other" / "results.csv", "utc\n");
  }
};

TEST(SessionFolders, EveryIdIsTextAndNoTwoFoldersShareOne) {
  CHECK_TRUE(rc::check("of any names", [](const std::string& a, const std::string& b) {
    RC_ASSERT(web::is_plain_text(web::session_id(a)));
    RC_ASSERT((web::session_id(a) == web::session_id(b)) == (a == b));
  }));
}

TEST(SessionFolders, NoIdLeadsOutOfTheFolder) {
  CHECK_TRUE(web::session_folder(sessions, "today").has_value());
  for (const char* id :
       {"", ".", "..", "../other", "today/../../other", "/", "today/", "%2e%2e", "..%2Fother"})
    CHECK_FALSE(web::session_folder(sessions, id).has_value());
  const auto parts = rc::gen::element<std::string>("..", ".", "/", "today", "other", "%2F", "\\",
                                                   std::string(1, '\0'), "%00", "\xff", "a");
  CHECK_TRUE(rc::check("of pieces of paths", [&] {
    std::string id;
    for (const std::string& part : *rc::gen::container<std::vector<std::string>>(parts)) id += part;
    const auto folder = web::session_folder(sessions, id);
    const bool inside = !folder || *folder == sessions / "today";
    RC_ASSERT(inside);
  }));
}

TEST(SessionFolders, AFileOfTheFoldersOwnIsReachedByNoLink) {
  const fs::path today = sessions / "today";
  CHECK_TRUE(web::is_own_file(today, today / "photographs" / "a.tif"));
  CHECK_FALSE(web::is_own_file(today, today / "photographs"));
  CHECK_FALSE(web::is_own_file(today, today / "photographs" / "b.tif"));
  CHECK_FALSE(web::is_own_file(today, today / ".." / "today" / "results.csv"));
  CHECK_FALSE(web::is_own_file(today, place / "other" / "results.csv"));
  fs::create_symlink(place / "other" / "results.csv", today / "link.csv");
  CHECK_FALSE(web::is_own_file(today, today / "link.csv"));
  fs::create_directory_symlink(place / "other", today / "linked");
  CHECK_FALSE(web::is_own_file(today, today / "linked" / "results.csv"));
}

TEST_GROUP(BoundedCache){};

TEST(BoundedCache, KeepsWhatWasUsedLastAndNoMoreThanItMay) {
  web::BoundedCache<int, std::string> cache(10);
  for (int i = 0; i < 5; ++i) cache.put(i, std::to_string(i), 3);
  LONGS_EQUAL(3, cache.size());
  CHECK_TRUE(cache.find(0) == nullptr);
  CHECK_EQUAL("2", *cache.find(2));
  cache.put(7, "7", 3);  // 3 is the one used longest ago
  CHECK_TRUE(cache.find(3) == nullptr);
  CHECK_TRUE(cache.find(2) != nullptr);
  cache.put(2, "two", 1);
  CHECK_EQUAL("two", *cache.find(2));
  LONGS_EQUAL(7, cache.cost());
  cache.put(9, "large", 50);  // the newest always
  LONGS_EQUAL(1, cache.size());
  cache.erase(9);
  LONGS_EQUAL(0, cache.cost());
}
