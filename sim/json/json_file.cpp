#include "sim/json/json_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include "hal/text/foreign_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

/// "file:12:5" of a byte of the text.
std::string place_at(const std::string& place, const std::string& text, std::size_t byte) {
  std::size_t line = 1, column = 1;
  for (std::size_t i = 0; i < byte && i < text.size(); ++i) {
    if (text[i] == '\n') {
      ++line;
      column = 1;
    } else {
      ++column;
    }
  }
  return place + ":" + std::to_string(line) + ":" + std::to_string(column);
}

/// Notes a key that its object already has: the parser itself would silently keep the last one.
class KeyChecker {
 public:
  bool operator()(nlohmann::json::parse_event_t event, const nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::object_start) open_.emplace_back();
    if (event == Event::object_end) open_.pop_back();
    if (event == Event::key) note(parsed.get_ref<const std::string&>());
    return true;
  }
  /// "Zone / Interior 1 / x_origin", or empty.
  const std::string& twice() const { return twice_; }

 private:
  struct OpenObject {
    std::set<std::string> keys;
    std::string current;
  };

  void note(const std::string& key) {
    open_.back().current = key;
    if (open_.back().keys.insert(key).second || !twice_.empty()) return;
    for (const auto& object : open_) twice_ += (twice_.empty() ? "" : " / ") + object.current;
  }

  std::vector<OpenObject> open_;
  std::string twice_;
};

/// The part of the parser's message after its own position.
std::string reason_of(const nlohmann::json::exception& error) {
  const std::string text = error.what();
  const auto colon = text.find(": ");
  return colon == std::string::npos ? text : text.substr(colon + 2);
}

/// Whether the text was cut: the parser wanted more, or a text has no end.
bool ends_early(const nlohmann::json::parse_error& error, const std::string& text) {
  const std::string_view said = error.what();
  return said.find("end of input") != std::string_view::npos ||
         (error.byte >= text.size() && said.find("missing closing quote") != std::string_view::npos);
}

}  // namespace

void refuse_deep_json(int depth, const std::string& place) {
  if (depth <= deepest_json) return;
  throw hal::InputError(place, fmt::format("brackets in brackets, more than {} deep", deepest_json),
                        "a model or a room", "see that this is the right file");
}

void refuse_json_number(const nlohmann::json::out_of_range& error, const std::string& place) {
  throw hal::InputError(place, reason_of(error), "numbers of at most 1.8e308", "correct the number");
}

nlohmann::json parse_json(const std::string& text, const std::string& place) {
  hal::refuse_foreign_text(text, place + ":1", "a JSON object");
  KeyChecker keys;
  nlohmann::json parsed;
  try {
    parsed = nlohmann::json::parse(text, [&](int depth, nlohmann::json::parse_event_t event, nlohmann::json& value) {
      refuse_deep_json(depth, place);
      return keys(event, value);
    });
  } catch (const nlohmann::json::out_of_range& error) {
    refuse_json_number(error, place);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t byte = error.byte > 0 ? error.byte - 1 : 0;
    throw hal::InputError(place_at(place, text, byte), "text that is not JSON (" + reason_of(error) + ")",
                          "a JSON object",
                          ends_early(error, text) ? "copy or download the file again, whole: it ends early"
                                                  : "correct the syntax there or just before");
  }
  if (!keys.twice().empty()) {
    throw hal::InputError(place + ": " + keys.twice(), "this key twice in one object", "each key once",
                          "remove or rename one of them");
  }
  return parsed;
}

std::string json_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::error_code unknown;
  const auto size = std::filesystem::is_regular_file(file) ? std::filesystem::file_size(file, unknown) : 0;
  std::string text(unknown ? 0 : static_cast<std::size_t>(size), '\0');
  if (!std::filesystem::is_regular_file(file) || !in ||
      !in.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw hal::InputError(file.string(), "no readable file", "a JSON file", "check the path and its permissions");
  }
  return text;
}

nlohmann::json read_json(const std::filesystem::path& file) { return parse_json(json_text(file), file.string()); }

}  // namespace airside::sim
