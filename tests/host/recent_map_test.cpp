#include "common/shot/recent_map.hpp"

#include <string>

#include "tests/support/string_from.hpp"

using strobe::RecentMap;

TEST_GROUP(RecentMap) { RecentMap<int, std::string> map{3}; };

TEST(RecentMap, ForgetsWhatWasEnteredFirstNotTheSmallestKey) {
  for (const int key : {9, 5, 7, 1}) map.put(key, std::to_string(key));
  CHECK(map.find(9) == nullptr);
  for (const int key : {5, 7, 1}) STRCMP_EQUAL(std::to_string(key).c_str(), map.find(key)->c_str());
}

TEST(RecentMap, KeepsTheAgeOfWhatIsReplaced) {
  for (const int key : {1, 2, 3}) map.put(key, "old");
  map.put(1, "new");
  STRCMP_EQUAL("new", map.find(1)->c_str());
  map.put(4, "new");
  CHECK(map.find(1) == nullptr);
  LONGS_EQUAL(3, map.all().size());
}

TEST(RecentMap, HasRoomAgainForWhatWasTaken) {
  for (const int key : {1, 2, 3}) map.put(key, "");
  CHECK_TRUE(map.take(2).has_value());
  CHECK_FALSE(map.take(2).has_value());
  map.put(4, "");
  for (const int key : {1, 3, 4}) CHECK(map.find(key) != nullptr);
}
