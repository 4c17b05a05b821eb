// Members of an object as text: those of the whole parser, and a complaint where the text ends early.

#include "sim/json/json_members.hpp"

#include <gtest/gtest.h>

#include "energyplus/engine.hpp"
#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

const std::string small_object = R"( {"a": {"b": [1, {"c": "}]\"\\"}]}, "d\"e": -1.5e3 , "f": "{[,:", "g":true,
  "h" : [], "i":{}, "j": null} )";

TEST(JsonMembers, AreThoseOfTheWholeParser) {
  const json whole = json::parse(small_object);
  const auto members = json_members(small_object, "t");
  ASSERT_EQ(members.size(), whole.size());
  for (const JsonMember& member : members) {
    const std::string key = json::parse('"' + std::string(member.key) + '"');
    ASSERT_TRUE(whole.contains(key)) << key;
    EXPECT_EQ(json::parse(member.value), whole[key]) << member.value;
  }
  EXPECT_TRUE(json_members("{}", "t").empty());
  EXPECT_TRUE(json_members(" { } ", "t").empty());
}

TEST(JsonMembers, OfATextThatEndsEarlyAreRefused) {
  const std::size_t whole = small_object.rfind('}') + 1;
  for (std::size_t length = 0; length < whole; ++length) {
    EXPECT_THROW((void)json_members(std::string_view(small_object).substr(0, length), "t"), hal::InputError) << length;
  }
  EXPECT_NO_THROW((void)json_members(std::string_view(small_object).substr(0, whole), "t"));
}

TEST(JsonMembers, OfWhatIsNoObjectAreRefused) {
  for (const char* wrong :
       {"[1]", "3", "\"a\"", "{a: 1}", "{\"a\" 1}", "{\"a\": }", "{\"a\": 1 \"b\": 2}", "{\"a\": 1,}"})
    EXPECT_THROW((void)json_members(wrong, "t"), hal::InputError) << wrong;
}

TEST(JsonMembers, OfTheEnginesSchemaAreItsObjectTypes) {
  AIRSIDE_NEEDS_ENGINE();
  const std::string schema = json_text(find_energyplus().schema);
  const json whole = json::parse(schema);
  std::size_t types = 0;
  for (const JsonMember& part : json_members(schema, "schema")) {
    if (part.key != "properties") continue;
    for (const JsonMember& type : json_members(part.value, "schema")) {
      ++types;
      EXPECT_EQ(json::parse(type.value), whole["properties"][std::string(type.key)]) << type.key;
    }
  }
  EXPECT_EQ(types, whole["properties"].size());
  EXPECT_GT(types, 800U);
}

}  // namespace
}  // namespace airside::sim
