// What a camera's driver and strobe say to each other, as lines.
#include "host/tether/driver_messages.hpp"

#include <variant>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::tether;

std::string event_error(const std::string& line) {
  const auto event = parse_event(line);
  return event ? "" : event.error().message;
}

}  // namespace

TEST_GROUP(DriverMessages){};

TEST(DriverMessages, RequestsComeBackAsTheyWere) {
  OpenRequest open;
  open.serial = "S\"7";
  open.address = "10.0.0.9";
  open.exposure_by_line = false;
  open.exposure_s = 0.25;
  open.set = {{"Gain", "1.5"}, {"PixelFormat", "Mono12"}};
  open.folder = "/tmp/a b";
  open.delete_from_camera = true;
  for (const Request& request : {Request{ListRequest{}}, Request{open}, Request{SnapRequest{0.5}}, Request{CheckRequest{}}}) {
    const auto read = parse_request(to_line(request));
    CHECK_TRUE(read.has_value());
    CHECK_EQUAL(to_line(request), to_line(*read));
    LONGS_EQUAL(request.index(), read->index());
  }
}

TEST(DriverMessages, EventsComeBackAsTheyWere) {
  const ExposureStart exposed{from_ns<HostTime>(123'456'789), Duration{1'500}};
  OpenedEvent opened;
  opened.camera = {"Maker", "M1", "S7", "1.2", "10.0.0.9"};
  opened.exposure = "while the line is active";
  opened.has_clock = true;
  opened.settings = {{"Gain", "0", "0.5", SettingState::rounded, "its smallest"}};
  opened.problems = {{true, "the card is full"}, {false, "the battery is low"}};
  for (const Event& event :
       {Event{CamerasEvent{{opened.camera, {}}}}, Event{opened}, Event{ReadyEvent{}}, Event{PhotographEvent{"a.tif", 7, exposed, 3}},
        Event{PhotographEvent{"a.nef", -1, std::nullopt, 0}}, Event{LostEvent{8, exposed, "two packets"}}, Event{GoneEvent{"silent"}},
        Event{FailedEvent{"no camera"}}, Event{NoteEvent{"hello"}}}) {
    const auto read = parse_event(to_line(event));
    CHECK_TRUE_TEXT(read.has_value(), to_line(event).c_str());
    CHECK_EQUAL(to_line(event), to_line(*read));
    LONGS_EQUAL(event.index(), read->index());
  }
}

TEST(DriverMessages, WhatIsNoEventIsNamed) {
  STRCMP_EQUAL("no JSON object", event_error("hello").c_str());
  STRCMP_EQUAL("no JSON object", event_error("[1]").c_str());
  STRCMP_EQUAL("event: is missing", event_error("{}").c_str());
  STRCMP_EQUAL("event: \"burnt\" is not known", event_error("{\"event\":\"burnt\"}").c_str());
  STRCMP_EQUAL("gone: why: is missing", event_error("{\"event\":\"gone\"}").c_str());
  STRCMP_EQUAL("gone: why: is of another kind", event_error("{\"event\":\"gone\",\"why\":3}").c_str());
  STRCMP_EQUAL("photograph: exposed_sd_ns: must be more than 0",
               event_error("{\"event\":\"photograph\",\"file\":\"a\",\"number\":1,\"exposed_ns\":5,\"exposed_sd_ns\":0,"
                           "\"packets_resent\":0}")
                   .c_str());
  STRCMP_EQUAL("cameras: cameras: must be a list", event_error("{\"event\":\"cameras\",\"cameras\":1}").c_str());
}

TEST(DriverMessages, ATextOfBytesThatAreNoTextIsStillALine) {
  const std::string line = to_line(Event{NoteEvent{"a\xff\n b"}});
  CHECK_TRUE(line.find('\n') == std::string::npos);
  CHECK_TRUE(parse_event(line).has_value());
}
