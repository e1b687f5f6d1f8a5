// Reports of synthetic sessions: what they hold, that they are the same each time, and that HTML and JSON say the same.
#include <fmt/format.h>
#include <rapidcheck.h>

#include <nlohmann/json.hpp>
#include <set>

#include "common/config/files.hpp"
#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/commission/record/record.hpp"
#include "host/report/hashes.hpp"
#include "host/report/report.hpp"
#include "tests/host/report/made_session.hpp"
#include "tests/host/report/parsed_html.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::report;
using namespace strobe::report_test;
using nlohmann::json;

namespace {

json json_of(const Report& report) { return json::parse(report_json(report)); }

/// Digits with what belongs to a number about them: "-0.5", "1e-05", "7.8.2.1".
std::set<std::string> numbers_in(const std::string& text) {
  std::set<std::string> out;
  std::string number;
  for (const char c : text + " ") {
    const bool within = (c >= '0' && c <= '9') || (!number.empty() && (c == '.' || c == 'e'));
    if (within) {
      number += c;
      continue;
    }
    while (!number.empty() && (number.back() == '.' || number.back() == 'e')) number.pop_back();
    if (!number.empty()) out.insert(number);
    number.clear();
  }
  return out;
}

/// All texts and numbers that the object holds, as a reader of it sees them.
void collect(const json& value, std::string& out) {
  if (value.is_string()) out += value.get<std::string>() + "\n";
  if (value.is_number()) out += value.dump() + "\n";
  if (value.is_structured())
    for (const auto& each : value) collect(each, out);
}

std::string without_pictures(const Report& report) {
  std::string out;
  collect(json_of(report), out);
  return out;
}

std::string text_of(const Report& report) {
  const auto parsed = parse_html(render_html(report));
  CHECK_TEXT(parsed.well_formed, parsed.problem.c_str());
  return parsed.text;
}

void write_grey(const std::string& file) {
  const cv::Mat grey(700, 1400, CV_8UC1, cv::Scalar(90));
  const auto png = image::encode_png(image::pixels_of(grey));
  CHECK(png.has_value());
  CHECK(config::write_file(file, {reinterpret_cast<const char*>(png->data()), png->size()}).has_value());
}

thesis::ThesisInputs loaded_thesis() {
  auto inputs = thesis::load_inputs(STROBE_THESIS_FOLDER, thesis::Version::corrected, "");
  CHECK_TEXT(inputs.has_value(), inputs ? "" : inputs.error().message.c_str());
  return *std::move(inputs);
}

}  // namespace

TEST_GROUP(Report){};

TEST(Report, SaysOnPaperWhatItSaysInJson) {
  auto input = input_of(made_session({.shots = 4, .rejected = 1}));
  const auto thesis = loaded_thesis();
  input.thesis = &thesis;
  input.all = true;
  using reduction::SpatialQuantity;
  auto& spatial = input.sessions[0].shots[0].readout.spatial.emplace();
  spatial[SpatialQuantity::omega_y_td_radps] = {-40.12, 1.2, 0.0};
  spatial[SpatialQuantity::omega_z_td_radps] = {185.3, 0.6, 0.0};
  spatial[SpatialQuantity::spin_axis_tilt_td_deg] = {12.25, 0.3, 0.4};
  input.limits = {*parse_limit("e=0.8..0.9"), *parse_limit("mu=0.1..0.2")};
  const Report report = build_report(input);
  const auto known = numbers_in(without_pictures(report));
  const auto shown = numbers_in(text_of(report));
  CHECK(shown.size() > 100);
  CHECK(shown.contains("12.25"));
  STRCMP_CONTAINS("aria-label=\"Spin axis as the camera sees it\"", render_html(report).c_str());
  for (const std::string& number : shown) CHECK_TEXT(known.contains(number), number.c_str());
}

TEST(Report, IsTheSameToTheByteForTheSameSession) {
  const Report first = build_report(input_of(made_session())),
               second = build_report(input_of(made_session()));
  CHECK_EQUAL(render_html(first), render_html(second));
  CHECK_EQUAL(report_json(first), report_json(second));
  LONGS_EQUAL(16, first.id.size());
}

TEST(Report, HasAnotherNameWhereAnythingIsDifferent) {
  std::set<std::string> ids{build_report(input_of(made_session())).id};
  ids.insert(build_report(input_of(made_session({.shots = 4}))).id);
  ids.insert(build_report(input_of(made_session({.rejected = 1}))).id);
  auto input = input_of(made_session());
  input.statements["customer"] = "Courts Ltd.";
  ids.insert(build_report(input).id);
  input.version = "1.2.4";
  ids.insert(build_report(input).id);
  LONGS_EQUAL(5, ids.size());
}

TEST(Report, NamesItselfOnEachPageAndEnds) {
  const Report report = build_report(input_of(made_session()));
  const auto parsed = parse_html(render_html(report));
  STRCMP_CONTAINS(("@bottom-left { content: \"Report " + report.id + "\"").c_str(), parsed.style.c_str());
  STRCMP_CONTAINS("\"page \" counter(page) \" of \" counter(pages)", parsed.style.c_str());
  const std::string end = "End of report " + report.id;
  CHECK(parsed.text.find(end) > parsed.text.find("7.8.6.2"));
}

TEST(Report, LoadsNothingAndRunsNothing) {
  const auto parsed = parse_html(render_html(build_report(input_of(made_session()))));
  std::string policy;
  for (const auto& element : parsed.elements) {
    CHECK(element.name != "script" && element.name != "link" && element.name != "iframe" &&
          element.name != "a");
    for (const auto& [name, value] : element.attributes) {
      CHECK_TEXT(name.rfind("on", 0) != 0, name.c_str());
      CHECK_TEXT(name != "src" || value.rfind("data:image/jpeg;base64,", 0) == 0, value.c_str());
      if (name == "content" && value.rfind("default-src", 0) == 0) policy = value;
    }
  }
  STRCMP_CONTAINS("default-src 'none'", policy.c_str());
  STRCMP_CONTAINS(("style-src '" + policy_hash(parsed.style) + "'").c_str(), policy.c_str());
  CHECK(parsed.style.find("url(") == std::string::npos);
}

TEST(Report, TellsOfARigThatNobodyCommissioned) {
  const json report = json_of(build_report(input_of(made_session())));
  CHECK_EQUAL("The rig is not commissioned.",
              report["sections"]["commissioning"]["texts"]["standing"].get<std::string>());
}

TEST(Report, HoldsTheRecordOfCommissioningAndItsDoubts) {
  testing::TemporaryFolder folder;
  host::StoredSession session = made_session();
  session.folder = folder.path();
  commission::RecordedStep step{"2026-11-20T10:00:00.000Z", "a@b", "1", "bench", "", "lamp A alone", {}};
  step.result.id = "lamp_a";
  step.result.state = commission::StepState::failed;
  step.result.value = 17.25;
  step.result.sd = 0.5;
  step.result.unit = "us";
  step.result.words = "lamp A <b>jitters</b>";
  testing::write_text(folder / commission::kRecordInSession, commission::record_line(step));
  const Report report = build_report(input_of(std::move(session)));
  const json section = json_of(report)["sections"]["commissioning"];
  const std::string standing = section["texts"]["standing"].get<std::string>();
  CHECK_TEXT(
      standing.starts_with("The rig is commissioned on 2026-11-20; failed: lamp_a; never done: firmware, "),
      standing.c_str());
  const std::string shown = text_of(report);
  CHECK(shown.find("lamp A <b>jitters</b>") != std::string::npos);
  CHECK(shown.find("17.25") != std::string::npos);
  CHECK(shown.find("record of commissioning") != std::string::npos);
}

TEST(Report, TellsWhatIsNotStatedAndListsIt) {
  auto input =
      input_of(made_session({.rig_lines = "[laboratory]\nname = \"Lab\"\n[report]\ncustomer = \"A\"\n"}));
  input.statements["customer"] = "B";
  const json all = json_of(build_report(input)).at("sections");
  CHECK_EQUAL(std::string("Lab"),
              all["identification"]["facts"]["who"]["laboratory"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("B"), all["identification"]["facts"]["who"]["customer"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("not stated"),
              all["identification"]["facts"]["who"]["address"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("jo@lab"),
              all["identification"]["facts"]["what"]["operator"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("2026-11-21"),
              all["identification"]["facts"]["what"]["issued"]["text"].get<std::string>());
  const auto listed = all["clauses"]["texts"]["not_stated"].get<std::string>();
  STRCMP_CONTAINS("section 1: Address, Contact,", listed.c_str());
  STRCMP_CONTAINS("Authorised by; section", listed.c_str());
  CHECK(listed.find("Customer,") == std::string::npos);
}

TEST(Report, ShowsNamesWithMarkupAsText) {
  const std::string evil = "<script>alert(1)</script>\"'&";
  auto input = input_of(made_session({.spin = evil, .angle = evil, .note = evil}));
  for (const auto& key : host::kStatementKeys)
    if (key.id != "issued" && key.id != "received") input.statements[std::string(key.id)] = evil;
  const auto parsed = parse_html(render_html(build_report(input)));
  CHECK_TEXT(parsed.well_formed, parsed.problem.c_str());
  LONGS_EQUAL(0, parsed.count("script"));
  STRCMP_CONTAINS(evil.c_str(), parsed.text.c_str());
}

TEST(Report, ShotsThatDoNotCountStayWithTheirReasons) {
  const json all = json_of(build_report(input_of(made_session({.shots = 3, .rejected = 2})))).at("sections");
  const json& rows = all["shots"]["tables"]["rejected"]["rows"];
  LONGS_EQUAL(2, rows.size());
  CHECK_EQUAL(std::string("a flash <was> missing"), rows[0]["reason"]["text"].get<std::string>());
  LONGS_EQUAL(3, all["shots"]["tables"]["numbers_zero_23"]["rows"].size());
  LONGS_EQUAL(3, all["photographs"]["shots"].size());
  CHECK_EQUAL(
      std::string("1 of 3 shots counted, in 1 condition. All messages are sealed with the laboratory's key."),
      all["identification"]["texts"]["in_short"].get<std::string>());
}

TEST(Report, SetsTheThesissRowBesideItsOwn) {
  auto input = input_of(made_session());
  const auto thesis = loaded_thesis();
  input.thesis = &thesis;
  const json all = json_of(build_report(input)).at("sections");
  const json& table = all["results"]["tables"]["parameters_1"];
  STRCMP_CONTAINS("Table 8", table["title"].get<std::string>().c_str());
  LONGS_EQUAL(4, table["rows"].size());
  // Table 8, zero spin, 23 degrees: e = .86 with an sd of .05.
  CHECK_EQUAL(std::string("0.86 ± 0.05"), table["rows"][2]["e"]["text"].get<std::string>());
  CHECK(table["rows"][2]["beside"].get<bool>());
  const double mean = table["rows"][0]["e"]["number"].get<double>();
  DOUBLES_EQUAL((mean - 0.86) / 0.05, table["rows"][3]["e"]["number"].get<double>(), 1e-12);
}

TEST(Report, DoesNotMentionTheThesissNumbersUnlessAsked) {
  const Report report = build_report(input_of(made_session({.shots = 8, .tops = true})));
  CHECK_FALSE(json_of(report).at("sections").contains("contact"));
  const std::string text = text_of(report);
  const std::size_t named = text.find("hesis");
  CHECK(named != text.npos);  // the method's source
  CHECK_EQUAL(text.npos, text.find("hesis", named + 1));
}

TEST(Report, NamesInstrumentsWithTheirCertificatesAndThoseThatAreOverdue) {
  const json all = json_of(build_report(input_of(made_session(
                               {.rig_lines = "[[report.instrument]]\nname = \"rule 17\"\ncertificate = \"K-1\"\ncalibrated "
                                             "= \"2025-11-01\"\ndue = \"2026-11-20\"\n[[report.instrument]]\nname = "
                                             "\"inclinometer\"\ncalibrated = \"2026-11-20\"\ndue = \"2026-11-21\"\n"}))))
                       .at("sections");
  const json& rows = all["set_up"]["tables"]["instruments"]["rows"];
  CHECK_EQUAL(std::string("K-1"), rows[0]["certificate"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("overdue"), rows[0]["state"]["text"].get<std::string>());  // tested on the 21st
  CHECK_EQUAL(std::string("not stated"), rows[1]["certificate"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("in force"), rows[1]["state"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("The calibration of rule 17 was due on 2026-11-20."),
              all["method"]["texts"]["deviation_1"].get<std::string>());
  const json without = json_of(build_report(input_of(made_session()))).at("sections");
  STRCMP_CONTAINS("Instruments and certificates", without["clauses"]["texts"]["not_stated"].get<std::string>().c_str());
}

TEST(Report, ShowsTheScaleThatCountsAndNotTheOneThatItSupersedes) {
  const json all = json_of(build_report(input_of(made_session(
                               {.rig_lines = "[analysis]\npx_per_m = 4321.0  # a guess\npx_per_m_sd = 9.0\n[camera]\npx_per_m = "
                                             "3975.123456\npx_per_m_sd = 1.99\nresidual_px = 0.0082528\n"}))))
                       .at("sections")
                       .at("set_up");
  CHECK_EQUAL(std::string("3975.1 ± 2.0 px/m"), all["facts"]["camera"]["px_per_m"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("0.0083 px"), all["facts"]["camera"]["residual_px"]["text"].get<std::string>());
  const std::string file = all["files"]["rig_file"]["text"].get<std::string>();
  CHECK_TEXT(file.find("4321") == file.npos && file.find("guess") == file.npos, file.c_str());
  STRCMP_CONTAINS("[camera]\npx_per_m = 3975.123456\n", file.c_str());
}

TEST(Report, SaysWhatErrorsOfClockAndInclinationWouldDo) {
  const json all = json_of(build_report(input_of(made_session({.shots = 3})))).at("sections");
  const json& rows = all["budgets"]["tables"]["overview_zero_23"]["rows"];
  const auto effect = [&](std::size_t from_end, const char* quantity) {
    return rows[rows.size() - from_end][quantity]["number"].get<double>();
  };
  STRCMP_CONTAINS("not included: clock's rate", rows[rows.size() - 2]["source"]["text"].get<std::string>().c_str());
  CHECK(rows.back()["beside"].get<bool>());
  // Speeds are as the clock's rate, but for what gravity adds over a leg of some 40 ms, 2 %; ratios are not.
  const double speed = all["results"]["tables"]["incoming_1"]["rows"][0]["v_td_mps"]["number"].get<double>();
  DOUBLES_EQUAL(1e-4 * speed, effect(2, "v_td_mps"), 0.03 * 1e-4 * speed);
  CHECK(effect(2, "e") < 1e-5);
  // g sin 1° along the surface for at most 60 ms.
  CHECK(effect(1, "v_td_mps") > 0.0 && effect(1, "v_td_mps") < 0.0103);
}

TEST(Report, HasOneKindOfUncertaintyForOneNumber) {
  testing::TemporaryFolder folder;
  write_grey(folder / "one.png");
  auto session = made_session({.shots = 1});
  session.folder = folder.path();
  session.shots[0].photograph = folder / "one.png";
  const auto readout = session.shots[0].readout;
  const double total = reduction::total_sd(readout, reduction::Quantity::v_td_mps).value();
  CHECK(total > 2.0 * readout.sd[reduction::Quantity::v_td_mps].value());  // scale by the ball: its tolerance counts
  const json all = json_of(build_report(input_of(session))).at("sections");
  const std::string text = all["photographs"]["shots"]["1"]["facts"]["v_td_mps"]["text"].get<std::string>();
  const double shown = std::stod(text.substr(text.find("± ") + 3));
  DOUBLES_EQUAL(total, shown, 0.05 * total);  // two digits
  const std::string value = all["shots"]["tables"]["numbers_zero_23"]["rows"][0]["v_td_mps"]["text"].get<std::string>();
  CHECK_EQUAL(text.substr(0, text.find(" ")), value);
}

TEST(Report, GivesNoAdviceToAnOperatorAndNoFolders) {
  auto session = made_session({.shots = 2});
  session.remarks = {"the photograph of shot 2 was never digitized"};
  session.advice = {"strobe replay /srv/lab/today --complete digitizes what was not"};
  session.folder = "/srv/lab/today";
  session.shots[1].photograph = session.folder / "photographs/absent.tif";
  const std::string text = text_of(build_report(input_of(std::move(session))));
  STRCMP_CONTAINS("shot 2 was never digitized", text.c_str());
  STRCMP_CONTAINS("cannot be shown: absent.tif", text.c_str());
  CHECK(text.find("/srv/lab") == text.npos);
  CHECK(text.find("strobe replay") == text.npos);
}

TEST(Report, HasNumbersOfEveryShotOfSeveralSessionsUnderOneConditionEach) {
  auto input = input_of(made_session({.shots = 2}));
  auto other = made_session({.shots = 3, .spin = "top", .angle = "34"});
  other.folder = "tomorrow";
  input.sessions.push_back(std::move(other));
  const json all = json_of(build_report(input)).at("sections");
  LONGS_EQUAL(5, all["photographs"]["shots"].size());
  CHECK(all["photographs"]["shots"].contains("tomorrow:3"));
  LONGS_EQUAL(2, all["shots"]["tables"]["numbers_zero_23"]["rows"].size());
  LONGS_EQUAL(3, all["shots"]["tables"]["numbers_top_34"]["rows"].size());
}

TEST(Report, OfASessionWithoutShotsSaysSo) {
  const Report report = build_report(input_of(made_session({.shots = 0})));
  const std::string text = text_of(report);
  STRCMP_CONTAINS("No shot was fired.", text.c_str());
  STRCMP_CONTAINS("0 of 0 shots counted", text.c_str());
  CHECK(text.find("nan") == std::string::npos);
}

TEST(Report, OfOneShotStatesNoUncertaintyThatItDoesNotHave) {
  const json all = json_of(build_report(input_of(made_session({.shots = 1})))).at("sections");
  const json& row = all["results"]["tables"]["uncertainty_zero_23"]["rows"][0];
  CHECK_EQUAL(std::string("-"), row["expanded_uncertainty"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("1"), row["n"]["text"].get<std::string>());
}

TEST(Report, StatesConformityByTheRuleThatItNames) {
  auto input = input_of(made_session({.shots = 4}));
  input.limits = {*parse_limit("e=0.5..1.2"), *parse_limit("mu=0.9..1.0")};
  const json all = json_of(build_report(input)).at("sections").at("conformity");
  STRCMP_CONTAINS("Guard bands", all["texts"]["decision_rule"].get<std::string>().c_str());
  const json& rows = all["tables"]["limits"]["rows"];
  CHECK_EQUAL(std::string("conforms"), rows[0]["conformity"]["text"].get<std::string>());
  CHECK_EQUAL(std::string("does not conform"), rows[1]["conformity"]["text"].get<std::string>());
  input.limits.clear();
  const json none = json_of(build_report(input)).at("sections").at("conformity");
  STRCMP_CONTAINS("no statement of conformity", none["texts"]["none"].get<std::string>().c_str());
}

TEST(Report, AnyNoteComesBackAsText) {
  CHECK(rc::check("notes are text", [] {
    const auto characters =
        *rc::gen::nonEmpty(rc::gen::container<std::vector<char>>(rc::gen::inRange('!', '\x7f')));
    const std::string note(characters.begin(), characters.end());
    Report report{.id = "0", .title = note, .issued = "", .sections = {{"s", note, {Paragraph{"p", note}}}}};
    report.sections[0].blocks.emplace_back(
        Facts{"f", note, {{.key = "k", .label = note, .text = note, .number = {}}}});
    report.sections[0].blocks.emplace_back(Table{"t", note, {{"c", note, note}}, {{{Cell(note)}}}, {note}});
    report.sections[0].blocks.emplace_back(ShotCard{
        .key = "1", .title = note, .picture = {}, .no_picture = note, .facts = {}, .remarks = {note}});
    const auto parsed = parse_html(render_html(report));
    RC_ASSERT(parsed.well_formed);
    std::size_t found = 0;
    for (std::size_t at = parsed.text.find(note + "\n"); at != parsed.text.npos;
         at = parsed.text.find(note + "\n", at + 1))
      ++found;
    RC_ASSERT(found >= 12U);
    RC_ASSERT(json::parse(report_json(report)).at("report").at("title").get<std::string>() == note);
  }));
}

TEST(Report, DrawsFigures4To17OfItsOwnImagesInContact) {
  auto input = input_of(made_session({.shots = 8, .tops = true}));
  const auto thesis = loaded_thesis();
  input.thesis = &thesis;
  const json charts = json_of(build_report(input)).at("sections").at("contact").at("charts");
  LONGS_EQUAL(14, charts.size());
  CHECK_FALSE(charts["figure_4_zero_23"]["caption"].get<std::string>().find("printed") != std::string::npos);
  const json& images = charts["figure_4_zero_23"]["panels"][0]["series"][0]["points"];
  CHECK(images.size() >= 5);
  double time_ms = 0.0, x_cm = 0.0;
  for (const json& point : images) {
    CHECK(point[0].get<double>() > time_ms && point[0].get<double>() < 5.3);  // the shots' dwell is 5.2 ms
    CHECK(point[1].get<double>() > x_cm && point[1].get<double>() < 6.6);     // over 6.29 cm
    time_ms = point[0].get<double>();
    x_cm = point[1].get<double>() - 0.1;  // shots differ by the noise of some .2 mm in two directions
  }
}

TEST(Report, ShowsAPhotographWithWhatWasMeasuredAndItsHash) {
  testing::TemporaryFolder folder;
  write_grey(folder / "one.png");
  auto session = made_session({.shots = 2});
  session.folder = folder.path();
  session.shots[0].photograph = folder / "one.png";
  session.shots[1].photograph = folder / "absent.png";
  const Report report = build_report(input_of(std::move(session)));
  const json all = json_of(report).at("sections");
  const json& picture = all["photographs"]["shots"]["1"]["picture"];
  LONGS_EQUAL(1100, picture["width_px"].get<int>());
  LONGS_EQUAL(550, picture["height_px"].get<int>());
  STRCMP_CONTAINS(("base64," + picture["jpeg_base64"].get<std::string>()).c_str(),
                  render_html(report).c_str());
  STRCMP_CONTAINS("absent.png", all["photographs"]["shots"]["2"]["no_picture"].get<std::string>().c_str());
  std::string hashes;
  for (const json& row : all["records"]["tables"]["files"]["rows"])
    hashes += row["sha256"]["text"].get<std::string>() + "\n";
  STRCMP_CONTAINS(sha256_of_file(folder / "one.png")->c_str(), hashes.c_str());
  STRCMP_CONTAINS("cannot be read", hashes.c_str());
}

TEST_GROUP(ReportHashes){};

TEST(ReportHashes, AreThoseOfTheStandard) {
  // FIPS 180-2, example of "abc"; RFC 4648, "foob".
  CHECK_EQUAL(std::string("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"),
              sha256_hex("abc"));
  const std::vector<std::uint8_t> bytes{'f', 'o', 'o', 'b'};
  CHECK_EQUAL(std::string("Zm9vYg=="), base64(bytes));
  CHECK_FALSE(sha256_of_file("/nowhere/at/all").has_value());
}
