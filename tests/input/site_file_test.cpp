#include "hal/site/site_file.hpp"

#include "support/complaint.hpp"

namespace airside::hal {
namespace {

SiteRules rules() {
  return {.topologies = {"5vav-5fcu-2power", "3vav-0fcu-1power"},
          .settings = {{"move_penalty", 0, 10, 0.1}, {"batch", 1, 1000, 128}}};
}

SiteFile parse(const std::string& text) { return parse_site_text(text, "room/site.toml", rules()); }

TEST(SiteFile, TakesAnyShape) {
  for (const char* shape : {"1vav-0fcu-0power", "6vav-2fcu-1power", "12vav-0fcu-1power", "32vav-32fcu-8power"}) {
    EXPECT_EQ(parse(example_site_text(shape)).topology, shape);
  }
}

TEST(SiteFile, ExampleIsAcceptedAndHoldsTheDefaults) {
  const SiteFile site = parse(example_site_text("5vav-5fcu-2power"));
  const SiteFile bare = parse("[site]\nname = \"Room 301\"\ntopology = \"5vav-5fcu-2power\"\n");
  EXPECT_EQ(site.name, "Room 301");
  EXPECT_EQ(site.room_temp_degc, bare.room_temp_degc);
  EXPECT_EQ(site.work_start_s, bare.work_start_s);
  EXPECT_EQ(site.work_end_s, 19 * 3600);
  EXPECT_EQ(site.setpoint_max_change_k, bare.setpoint_max_change_k);
  EXPECT_EQ(site.setpoint_round_k, bare.setpoint_round_k);
  EXPECT_EQ(site.expert_work_degc, bare.expert_work_degc);
  EXPECT_EQ(site.expert_off_degc, bare.expert_off_degc);
  EXPECT_EQ(site.preset, bare.preset);
  EXPECT_EQ(site.seed, bare.seed);
  EXPECT_EQ(site.state_dir, bare.state_dir);
  EXPECT_EQ(site.log_max_files, bare.log_max_files);
  EXPECT_EQ(site.log_max_file_mb, bare.log_max_file_mb);
  EXPECT_EQ(site.history_log, "");
  ASSERT_TRUE(site.modbus.has_value());
  EXPECT_EQ(site.modbus->points, "room/points.csv");
  EXPECT_EQ(site.modbus->unit_id, 1);
  EXPECT_FALSE(bare.modbus.has_value());
  EXPECT_FALSE(site.twin.has_value());
}

TEST(SiteFile, ExampleWithItsCommentsRemovedIsAcceptedToo) {
  std::string text = example_site_text("3vav-0fcu-1power");
  for (const char* mark : {"# move_penalty", "# [twin]", "# model", "# patches", "# weather"}) {
    text = replaced(text, mark, mark + 2);
  }
  const SiteFile site = parse(text);
  EXPECT_EQ(site.overrides.at("move_penalty"), 0.1);
  ASSERT_TRUE(site.twin.has_value());
  EXPECT_EQ(site.twin->model, "room/twin.epJSON");
  EXPECT_EQ(site.twin->patches, std::vector<std::string>{"room/room301.json"});
  EXPECT_EQ(site.twin->weather, "room/site.epw");
}

TEST(SiteFile, ReadsWhatDiffersFromTheDefaults) {
  std::string text = example_site_text("5vav-5fcu-2power");
  text = replaced(text, "room_temp_degc = 25.25", "room_temp_degc = 24");
  text = replaced(text, "\"07:00\"", "07:30:00");
  text = replaced(text, "\"19:00\"", "\"24:00\"");
  text = replaced(text, "transport = \"tcp\"", "transport = \"rtu\"");
  text = replaced(text, "parity = \"E\"", "parity = \"N\"");
  text = replaced(text, "preset = \"product\"", "preset = \"paper\"");
  text = replaced(text, "\"points.csv\"", "\"/etc/airside/points.csv\"");
  text = replaced(text, "source = \"system\"", "source = \"plant\"");
  const SiteFile site = parse(text);
  EXPECT_EQ(site.room_temp_degc, 24.0);
  EXPECT_EQ(site.work_start_s, 27000);
  EXPECT_EQ(site.work_end_s, 86400);
  EXPECT_EQ(site.modbus->transport, ModbusTransport::rtu);
  EXPECT_EQ(site.modbus->parity, 'N');
  EXPECT_EQ(site.preset, ControllerPreset::paper);
  EXPECT_EQ(site.modbus->points, "/etc/airside/points.csv");
  EXPECT_EQ(site.clock, ClockSource::plant);
}

TEST(SiteFile, ReadsWhatIsHeld) {
  const std::string text = example_site_text("3vav-0fcu-1power");
  EXPECT_EQ(parse(text).held.rule, HoldRule::mean);
  EXPECT_EQ(parse(replaced(text, "hold = \"mean\"", "hold = \"middle\"")).held.rule, HoldRule::middle);
  const SiteFile site = parse(replaced(text, "hold = \"mean\"", "hold = \"weighted\"\nweights = [1, 0, 2.5]"));
  EXPECT_EQ(site.held.rule, HoldRule::weighted);
  EXPECT_EQ(site.held.weights[0], 1);
  EXPECT_EQ(site.held.weights[1], 0);
  EXPECT_EQ(site.held.weights[2], 2.5);
}

TEST(SiteFile, BandHoldsEveryZoneItself) {
  const std::string text = example_site_text("3vav-0fcu-1power", Objective::band);
  EXPECT_NO_THROW(parse(text));
  expect_complaint({"controller.objective", "\"band\" beside hold = \"middle\"", "hold = \"mean\"", "out of [target]"},
                   [&text] { parse(replaced(text, "hold = \"mean\"", "hold = \"middle\"")); });
}

TEST(SiteFile, MissingFileIsNamed) {
  expect_complaint({"no/such/site.toml", "no file", "site file", "check the path"},
                   [] { read_site_file("no/such/site.toml", rules()); });
  expect_complaint({AIRSIDE_SOURCE_DIR, "a directory", "site file", "the file in it"},
                   [] { read_site_file(AIRSIDE_SOURCE_DIR, rules()); });
}

struct Case {
  const char* name;
  const char* from;  ///< text of the example that is replaced
  const char* to;
  Complaint want;
};

const Case cases[] = {
    {"SyntaxError",
     "min_degc = 20.0",
     "min_degc = = 20",
     {"room/site.toml:17:", "not TOML", "key = value", "correct the line"}},
    {"SameKeyTwice", "step_k = 0.1", "min_degc = 21", {":19:", "not TOML", "key = value", "keep one of the two"}},
    {"BytesThatAreNotUtf8", "Room 301", "Room \xFF\xFE", {":5:", "not TOML", "key = value", "save the file as UTF-8"}},
    {"NoName", "name = \"Room 301\"", "", {":4:1: site.name", "nothing", "a text", "add name = \"Room 301\""}},
    {"NameWithMarkup", "Room 301", "<script>", {":5:1: site.name", "<script>", "without", "use letters"}},
    {"NoTopology",
     "topology = ",
     "# topology = ",
     {": site.topology", "nothing", "a text", "add topology = \"5vav-5fcu-2power\" to [site]"}},
    {"TopologyMistyped",
     "5vav-5fcu-2power",
     "5vav-5fcu-2powers",
     {":6:1: site.topology", "5vav-5fcu-2powers", "5vav-5fcu-2power, 3vav", "did you mean \"5vav-5fcu-2power\""}},
    {"TopologyOfTooManyMeters",
     "5vav-5fcu-2power",
     "40vav-0fcu-20power",
     {":6:1: site.topology", "40vav-0fcu-20power", "1 to 32 VAV boxes", "write it like 6vav"}},
    {"InboxIsTheStateFolder",
     "dir = \"inbox\"",
     "dir = \"state\"",
     {": inbox.dir", "which is [state] dir", "a folder of its own", "name another"}},
    {"TargetAsText",
     "room_temp_degc = 25.25",
     "room_temp_degc = \"25,25\"",
     {":10:1: target.room_temp_degc", "the text \"25,25\"", "10 to 40 degC", "without quotes"}},
    {"TargetInFahrenheit",
     "room_temp_degc = 25.25",
     "room_temp_degc = 77.5",
     {":10:1: target.room_temp_degc", "77.5", "10 to 40 degC", "default is 25.25"}},
    {"TargetNotANumber",
     "room_temp_degc = 25.25",
     "room_temp_degc = nan",
     {":10:1: target.room_temp_degc", "nan", "10 to 40", "range"}},
    {"TargetMistyped",
     "room_temp_degc = 25.25",
     "room_tmp_degc = 25.25",
     {":10:1: target.room_tmp_degc", "unknown key `room_tmp_degc`", "room_temp_degc", "did you mean `room_temp_degc`"}},
    {"HourThatDoesNotExist",
     "\"07:00\"",
     "\"25:00\"",
     {":12:1: target.work_start", "25:00", "00:00 to 24:00", "\"07:00\""}},
    {"HourAsNumber", "\"07:00\"", "7", {":12:1: target.work_start", "7", "a time of day", "\"07:00\""}},
    {"WorkEndsBeforeItStarts",
     "\"19:00\"",
     "\"06:00\"",
     {":13:1: target.work_end", "06:00", "work_start before work_end", "night shift"}},
    {"FlagAsText",
     "weekday_only = false",
     "weekday_only = \"no\"",
     {":14:1: target.weekday_only", "\"no\"", "true or false", "without quotes"}},
    {"HoldUnknown",
     "hold = \"mean\"",
     "hold = \"middel\"",
     {":11:1: target.hold", "middel", "one of mean, weighted, middle", "did you mean \"middle\""}},
    {"WeightsWithoutTheirRule",
     "hold = \"mean\"",
     "weights = [1, 1, 1, 1, 2]",
     {":11:1: target.weights", "hold = \"mean\"", "only where hold", "set hold = \"weighted\""}},
    {"WeightsMissing",
     "hold = \"mean\"",
     "hold = \"weighted\"",
     {": target.weights", "nothing", "5 weights, one a VAV box", "weights = [1, 1, 2]"}},
    {"WeightsOfAnotherCount",
     "hold = \"mean\"",
     "hold = \"weighted\"\nweights = [1, 2]",
     {":12:1: target.weights", "2 of them", "5 weights, one a VAV box of 5vav-5fcu-2power", "order of the boxes"}},
    {"WeightsAllZero",
     "hold = \"mean\"",
     "hold = \"weighted\"\nweights = [0, 0, 0, 0, 0]",
     {":12:1: target.weights", "all 0", "one of them above 0", "hold = \"mean\""}},
    {"WeightNegative",
     "hold = \"mean\"",
     "hold = \"weighted\"\nweights = [1, 1, -1, 1, 1]",
     {":12:1: target.weights", "number 3 of the list: -1", "0 to 1000", "that range"}},
    {"WeightAsText",
     "hold = \"mean\"",
     "hold = \"weighted\"\nweights = [1, \"2\", 1, 1, 1]",
     {":12:1: target.weights", "number 2 of the list", "numbers", "without quotes"}},
    {"WeightsNoList",
     "hold = \"mean\"",
     "hold = \"weighted\"\nweights = 2",
     {":12:1: target.weights", "2", "a list of numbers", "[1, 1.5, 2]"}},
    {"LimitsExchanged",
     "max_degc = 26.0",
     "max_degc = 19",
     {":18:1: setpoint.max_degc", "19", "min_degc below max_degc", "exchange"}},
    {"StepZero", "step_k = 0.1", "step_k = 0", {":19:1: setpoint.step_k", "0", "0.05 to 2 K", "default is 0.1"}},
    {"ExpertOutOfRange",
     "work_degc = 20.5",
     "work_degc = 205",
     {":25:1: expert.work_degc", "205", "5 to 40 degC", "default is 20.5"}},
    {"PresetUnknown",
     "preset = \"product\"",
     "preset = \"papr\"",
     {":29:1: controller.preset", "papr", "one of product, paper, paper-repaired", "did you mean \"paper\""}},
    {"SeedNegative", "seed = 1", "seed = -1", {":32:1: controller.seed", "-1", "whole number from 0", "range"}},
    {"SeedWithPoint", "seed = 1", "seed = 1.5", {":32:1: controller.seed", "1.5", "whole number", "decimal point"}},
    {"OverrideUnknown",
     "# move_penalty = 0.1",
     "move_penalti = 0.1",
     {":35:1: controller.override.move_penalti", "unknown setting", "a setting", "did you mean `move_penalty`"}},
    {"OverrideOutOfRange",
     "# move_penalty = 0.1",
     "move_penalty = 11",
     {":35:1: controller.override.move_penalty", "11", "0 to 10", "default is 0.1"}},
    {"OverrideOfSettingWithOwnKey",
     "# move_penalty = 0.1",
     "target_degc = 24",
     {":35:1: controller.override.target_degc", "an override", "without a key", "room_temp_degc in [target]"}},
    {"OverrideNotATable",
     "[controller.override]",
     "override = 3\n",
     {":34:1: controller.override", "3", "a table", "[controller.override]"}},
    {"TransportUnknown",
     "transport = \"tcp\"",
     "transport = \"udp\"",
     {":38:1: modbus.transport", "udp", "one of tcp, rtu", "did you mean"}},
    {"HostMissing",
     "host = ",
     "# host = ",
     {":37:1: modbus.host", "nothing", "a text", "add host = \"192.168.1.20\" to [modbus]"}},
    {"HostEmpty",
     "host = \"127.0.0.1\"",
     "host = \"\"",
     {":39:1: modbus.host", "an empty text", "the address of the AHU's controller", "host = \"192.168.1.20\""}},
    {"DeviceMissing",
     "transport = \"tcp\"        # tcp or rtu\nhost = \"127.0.0.1\"       # tcp\nport = 502\ndevice",
     "transport = \"rtu\"\nport = 502\n#",
     {": modbus.device", "nothing", "a text", "/dev/ttyUSB0"}},
    {"PortTooLarge", "port = 502", "port = 70000", {":40:1: modbus.port", "70000", "1 to 65535", "default is 502"}},
    {"ParityUnknown",
     "parity = \"E\"",
     "parity = \"even\"",
     {":43:1: modbus.parity", "even", "one of N, E, O", "choose"}},
    {"UnitIdTooLarge", "unit_id = 1", "unit_id = 300", {":44:1: modbus.unit_id", "300", "0 to 247", "range"}},
    {"BaudTooSlow", "baud = 19200", "baud = 300", {": modbus.baud", "300", "1200 to 921600", "range"}},
    {"MetersOfAnotherNumber",
     "scope = \"Room 301\"",
     "meters = [\"fans\"]\nscope = \"Room 301\"",
     {": site.meters", "a list", "2 names, one a power meter", "leave it out"}},
    {"MeterWithMarkup",
     "scope = \"Room 301\"",
     "meters = [\"fans\", \"<b>\"]\nscope = \"Room 301\"",
     {": site.meters", "<b>", "without control characters", "letters"}},
    {"BaudThatNoLineHas", "baud = 19200", "baud = 19201", {": modbus.baud", "19201", "one of 1200, 2400", "manuals"}},
    {"SerialUnitZero",
     "transport = \"tcp\"        # tcp or rtu\nhost = \"127.0.0.1\"       # tcp\nport = 502\ndevice",
     "transport = \"rtu\"\nunit_id = 0\ndevice = \"/dev/ttyS0\"\n[ignored]\ndevice",
     {": modbus.unit_id", "0", "1 to 247", "range"}},
    {"DeadlineTooLong",
     "deadline_s = 5.0",
     "deadline_s = 60",
     {":45:1: modbus.deadline_s", "60", "0.1 to 10 s", "range"}},
    {"HeartbeatTooFast",
     "heartbeat_s = 20.0",
     "heartbeat_s = 1.0",
     {":46:1: modbus.heartbeat_s", "1", "5 to 360 s", "range"}},
    {"PointsNotAText",
     "points = \"points.csv\"",
     "points = [1]",
     {":47:1: modbus.points", "a list", "text in quotes", "double quotes"}},
    {"ClockUnknown", "source = \"system\"", "source = \"ntp\"", {":50:1: clock.source", "ntp", "system, plant", ""}},
    {"LogFilesZero", "max_files = 40", "max_files = 0", {":59:1: log.max_files", "0", "2 to 4000", "range"}},
    {"SectionMistyped",
     "[weights]",
     "[weigths]",
     {":65:", "unknown key `weigths`", "weights", "did you mean `weights`"}},
    {"PatchesNotTexts",
     "# [twin]\n# model",
     "[twin]\nmodel = \"rc\"\npatches = [1]\n#",
     {"twin.patches", "a list", "a list of texts", "double quotes"}},
    {"PatchesNotAList",
     "# [twin]\n# model",
     "[twin]\nmodel = \"rc\"\npatches = \"a.json\"\n#",
     {"twin.patches", "a.json", "a list of texts", "[\"first\", \"second\"]"}},
};

class BrokenSiteFile : public testing::TestWithParam<Case> {};

TEST_P(BrokenSiteFile, IsRefusedWithPlaceFoundExpectedAndRemedy) {
  const Case& c = GetParam();
  const std::string text = replaced(example_site_text("5vav-5fcu-2power"), c.from, c.to);
  expect_complaint(c.want, [&] { parse(text); });
}

INSTANTIATE_TEST_SUITE_P(Table, BrokenSiteFile, testing::ValuesIn(cases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(SiteFile, EmptyAndBinaryFilesAreRefused) {
  expect_complaint({"room/site.toml: site", "nothing", "[site]", "start from"}, [] { parse(""); });
  expect_complaint({":1:1", "not text", "TOML", ".toml"}, [] {
    parse(
        std::string("\x7F"
                    "ELF\0\1",
                    6));
  });
}

TEST(SiteFile, EveryPrefixOfTheExampleIsAcceptedOrRefusedWithAnInputError) {
  const std::string text = example_site_text("5vav-5fcu-2power");
  for (std::size_t size = 0; size < text.size(); ++size) {
    try {
      parse(text.substr(0, size));
    } catch (const InputError&) {
    }
  }
}

}  // namespace
}  // namespace airside::hal
