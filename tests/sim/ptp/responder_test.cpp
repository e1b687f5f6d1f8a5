// What the simulated PTP camera answers, its settings and its card.
#include "sim/ptp/responder.hpp"

#include <string>

#include "sim/ptp/dataset.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::sim::ptp;
using strobe::testing::TemporaryFolder;

std::vector<std::uint32_t> array_in(const Answer& answer) {
  DatasetReader reader(*answer.data);
  std::vector<std::uint32_t> values(reader.u32());
  for (std::uint32_t& value : values) value = reader.u32();
  return values;
}

}  // namespace

TEST_GROUP(PtpResponder) {
  TemporaryFolder folder;
  Properties properties;
  Card card{folder.path(), 9999};
  Responder responder{"S1", properties, card};

  Answer ask(Operation code, std::vector<std::uint32_t> parameters = {}, Bytes data = {}) {
    return responder.answer({!data.empty(), code, 1, std::move(parameters), std::move(data)});
  }
  std::string store(const std::string& extension, const std::string& content) {
    const std::string file = card.next_stem().string() + extension;
    strobe::testing::write_text(file, content);
    card.add(file, ObjectFormat::tiff, "20261127T120000");
    return file;
  }
  std::string name_of(std::uint32_t handle) {
    const Answer answer = ask(Operation::get_object_info, {handle});
    DatasetReader reader(*answer.data);
    for (int i = 0; i < 4 + 4 + 5; ++i) reader.u32();  // 52 bytes of numbers before the name
    return reader.text();
  }
};

TEST(PtpResponder, DescribesItselfWithoutASessionAndNothingElse) {
  CHECK(ask(Operation::get_device_info).data.has_value());
  CHECK(ask(Operation::get_storage_ids).code == Response::session_not_open);
  CHECK(ask(Operation::open_session, {1}).code == Response::ok);
  CHECK(ask(Operation::open_session, {1}).code == Response::session_already_open);
  CHECK(ask(Operation::get_storage_ids).code == Response::ok);
  CHECK(ask(static_cast<Operation>(0x9999)).code == Response::operation_not_supported);
  responder.end_session();
  CHECK(ask(Operation::get_storage_ids).code == Response::session_not_open);
}

TEST(PtpResponder, ListsReadsAndRemovesFiles) {
  ask(Operation::open_session, {1});
  const std::string file = store(".TIF", "0123456789");
  const auto all = array_in(ask(Operation::get_object_handles, {Card::kStorage, 0, 0}));
  LONGS_EQUAL(3, all.size());  // DCIM, its folder, the file
  const std::uint32_t handle = all.back();
  CHECK_EQUAL("DSC_9999.TIF", name_of(handle));
  LONGS_EQUAL(3, ask(Operation::get_num_objects, {Card::kStorage, 0, 0}).parameters[0]);
  CHECK(*ask(Operation::get_object, {handle}).data == Bytes({'0', '1', '2', '3', '4', '5', '6', '7', '8', '9'}));
  const Answer part = ask(Operation::get_partial_object, {handle, 8, 5});
  CHECK(*part.data == Bytes({'8', '9'}));
  LONGS_EQUAL(2, part.parameters[0]);
  CHECK(ask(Operation::get_partial_object, {handle, 100, 5}).data->empty());
  CHECK(ask(Operation::delete_object, {handle}).code == Response::ok);
  CHECK(ask(Operation::get_object, {handle}).code == Response::invalid_object);
  CHECK(!std::filesystem::exists(file));
}

TEST(PtpResponder, BeginsANewFolderWithTheFirstNumberAfter9999) {
  ask(Operation::open_session, {1});
  store(".TIF", "a");
  const std::string next = store(".TIF", "b");
  CHECK_EQUAL("101STROB/DSC_0001.TIF", std::filesystem::relative(next, folder.path()).string());
  const auto all = array_in(ask(Operation::get_object_handles, {Card::kStorage, 0, 0xFFFFFFFF}));
  LONGS_EQUAL(1, all.size());  // DCIM alone is in no folder
  LONGS_EQUAL(2, array_in(ask(Operation::get_object_handles, {Card::kStorage, 0, all[0]})).size());
}

TEST(PtpResponder, RoundsIsoAndRefusesOtherValuesThatItHasNot) {
  ask(Operation::open_session, {1});
  const auto set = [this](PropertyCode code, Bytes data) {
    return ask(Operation::set_property_value, {number(code)}, std::move(data)).code;
  };
  CHECK(set(PropertyCode::exposure_index, DatasetWriter().u16(350).take()) == Response::ok);
  LONGS_EQUAL(400, properties.get(PropertyCode::exposure_index));
  CHECK(set(PropertyCode::f_number, DatasetWriter().u16(123).take()) == Response::invalid_property_value);
  CHECK(set(PropertyCode::f_number, Bytes{1}) == Response::invalid_property_format);
  CHECK(set(PropertyCode::battery_level, Bytes{50}) == Response::access_denied);
  CHECK(ask(Operation::set_property_value, {0x5FFF}, Bytes{1}).code == Response::property_not_supported);
}

TEST(PtpResponder, TakesNoPictureOntoAFullCard) {
  ask(Operation::open_session, {1});
  CHECK(ask(Operation::initiate_capture).code == Response::ok);
  CHECK(ask(Operation::initiate_capture).code == Response::device_busy);
  CHECK(responder.take_capture());
  CHECK_FALSE(responder.take_capture());
  card.set_full(true);
  CHECK(ask(Operation::initiate_capture).code == Response::store_full);
}

TEST(PtpResponder, WritesWhatTheCompressionSays) {
  const auto written = [this](std::uint64_t compression) {
    properties.put(PropertyCode::compression, compression);
    const FilesWritten files = properties.files_written();
    return std::string(files.raw ? "raw " : "") + (files.jpeg ? "jpeg" : "");
  };
  CHECK_EQUAL("raw ", written(4));
  CHECK_EQUAL("raw jpeg", written(7));
  CHECK_EQUAL("jpeg", written(2));
}
