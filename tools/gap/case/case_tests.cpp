#include "tools/gap/case/case_tests.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"
#include "tools/gap/model/patched_model.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;

constexpr const char* tests_file = "tests.json";

}  // namespace

std::vector<CaseTest> read_case_tests(const fs::path& folder) {
  const fs::path file = folder / tests_file;
  if (!fs::exists(file)) return {};
  const nlohmann::json j = sim::read_json(file);
  const auto refuse = [&file](const std::string& key, const std::string& found, const std::string& expected) {
    throw hal::InputError(file.string() + ": " + key, found, expected,
                          "see docs/formats.md, \"Cases of the gap workflow\", or remove the file and its logs");
  };
  const bool known = j.is_object() && j.value("format", nlohmann::json()) == 1 && j.contains("tests");
  if (!known || !j["tests"].is_array()) refuse("tests", j.dump().substr(0, 60), "format 1 and a list of tests");
  std::vector<CaseTest> tests;
  for (const nlohmann::json& one : j["tests"]) {
    const std::string place = fmt::format("tests[{}]", tests.size());
    const auto text = [&](const char* key) {
      if (!one.is_object() || !one.contains(key) || !one[key].is_string()) refuse(place + "." + key, "none", "a text");
      return one[key].get<std::string>();
    };
    const auto from = hal::parse_civil_text(text("from"));
    if (!from) refuse(place + ".from", text("from"), "a time like 2021-07-01T00:00:00");
    tests.push_back({text("test"), text("log"), *from});
  }
  return tests;
}

void write_case_tests(const fs::path& folder, const std::vector<CaseTest>& tests) {
  nlohmann::json list = nlohmann::json::array();
  for (const CaseTest& test : tests)
    list.push_back({{"test", test.name}, {"log", test.log}, {"from", hal::civil_text(test.from)}});
  write_whole_file(folder / tests_file, nlohmann::json{{"format", 1}, {"tests", list}}.dump(1) + "\n");
}

}  // namespace airside::tools::gap
