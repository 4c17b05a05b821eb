#include "sim/json/merge_patch.hpp"
#include "sim/json/json_file.hpp"

#include <gtest/gtest.h>

#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

struct MergeCase {
  const char *model, *patch, *expected;
};

TEST(MergePatch, FollowsTheExamplesOfTheStandard) {
  // RFC 7386, appendix A, those whose target and patch are objects.
  for (const MergeCase& c : {MergeCase{R"({"a":"b"})", R"({"a":"c"})", R"({"a":"c"})"},
                             MergeCase{R"({"a":"b"})", R"({"b":"c"})", R"({"a":"b","b":"c"})"},
                             MergeCase{R"({"a":"b"})", R"({"a":null})", R"({})"},
                             MergeCase{R"({"a":"b","b":"c"})", R"({"a":null})", R"({"b":"c"})"},
                             MergeCase{R"({"a":["b"]})", R"({"a":"c"})", R"({"a":"c"})"},
                             MergeCase{R"({"a":"c"})", R"({"a":["b"]})", R"({"a":["b"]})"},
                             MergeCase{R"({"a":{"b":"c"}})", R"({"a":{"b":"d","c":null}})", R"({"a":{"b":"d"}})"},
                             MergeCase{R"({"a":[{"b":"c"}]})", R"({"a":[1]})", R"({"a":[1]})"},
                             MergeCase{R"({})", R"({"a":{"bb":{"ccc":null}}})", R"({"a":{"bb":{}}})"}}) {
    EXPECT_EQ(merge_patched(json::parse(c.model), json::parse(c.patch), "patch"), json::parse(c.expected))
        << c.model << " + " << c.patch;
  }
}

TEST(MergePatch, RefusesWhatIsNoObject) {
  EXPECT_THROW(merge_patched(json::object(), json::array(), "patch"), hal::InputError);
  EXPECT_THROW(merge_patched(json(3), json::object(), "patch"), hal::InputError);
}

std::string complaint(const std::string& text) {
  try {
    parse_json(text, "room.json");
  } catch (const hal::InputError& error) {
    return error.what();
  }
  return {};
}

TEST(JsonReader, SaysLineAndColumnOfASyntaxError) {
  const std::string missing_comma = "{\n  \"a\": 1\n  \"b\": 2\n}\n";
  EXPECT_NE(complaint(missing_comma).find("room.json:3:5"), std::string::npos) << complaint(missing_comma);
  EXPECT_NE(complaint("").find("room.json:1:1"), std::string::npos) << complaint("");
}

TEST(JsonReader, RefusesAKeyGivenTwice) {
  const std::string text = R"({"Zone": {"Interior 1": {"x_origin": 0, "x_origin": 1}}})";
  EXPECT_NE(complaint(text).find("Zone / Interior 1 / x_origin"), std::string::npos) << complaint(text);
  EXPECT_EQ(complaint(R"({"a": {"x": 0}, "b": {"x": 1}})"), "");
}

TEST(JsonReader, RefusesNumbersThatNoDoubleHoldsAndBottomlessBrackets) {
  EXPECT_NE(complaint(R"({"a": 1e999})").find("number overflow"), std::string::npos) << complaint(R"({"a": 1e999})");
  EXPECT_NE(complaint("{\"a\":" + std::string(200000, '[')).find("brackets in brackets"), std::string::npos);
}

TEST(JsonReader, NamesAFileThatIsNotThere) {
  EXPECT_THROW(read_json("/nonexistent/model.epJSON"), hal::InputError);
  EXPECT_THROW(read_json("/tmp"), hal::InputError);
}

}  // namespace
}  // namespace airside::sim
