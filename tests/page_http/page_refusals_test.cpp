// Every refusal says by a code of refusals.hpp what it refuses, and what it found and expected where that says more.
// tests/page_browser/texts.mjs holds those codes to the texts of all languages.

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "firmware/page/auth/access_file.hpp"
#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

class PageRefusals : public PageRig {
 protected:
  /// What was answered to a blob, by a peer of its own: one that was refused must wait.
  json answer_to(const Bytes& blob) { return json::parse(body_of(ask(post(blob), next_peer())), nullptr, false); }
  std::string next_peer() { return "127.0.1." + std::to_string(++last_peer_); }

  /// A blob whose header was changed before it was signed.
  template <class Change>
  Bytes signed_with(const Change& change, Bytes blob = plain_blob()) const {
    BlobHeader header;
    std::memcpy(&header, blob.data(), sizeof header);
    change(header);
    std::memcpy(blob.data(), &header, sizeof header);
    return signed_blob(10, blob);
  }

 private:
  int last_peer_ = 0;
};

void expect_refusal(const json& answer, int status, const std::string& code, const std::string& field = "") {
  ASSERT_TRUE(answer.is_object()) << code << ": " << answer;
  EXPECT_EQ(answer.value("status", 0), status) << answer;
  EXPECT_EQ(answer.value("code", ""), code) << answer;
  EXPECT_EQ(answer.value("field", ""), field) << answer;
  EXPECT_FALSE(answer.value("reason", "").empty()) << answer;
}

TEST_F(PageRefusals, OfWeightsNameCodeFieldFoundAndExpected) {
  ASSERT_TRUE(start()) << read("said.txt");
  Bytes by_stranger = plain_blob(), changed = signed_blob(), cut = signed_blob();
  hal::sign_blob(by_stranger, hal::make_key("mallory"), 10);
  changed[500] ^= std::byte{1};
  const std::string whole = std::to_string(cut.size());
  cut.resize(cut.size() - 100);
  expect_refusal(answer_to(plain_blob()), 403, "weights_key", "key_id");
  expect_refusal(answer_to(by_stranger), 403, "weights_key", "key_id");
  expect_refusal(answer_to(changed), 403, "weights_signature", "signature");
  expect_refusal(answer_to(Bytes(300, std::byte{'x'})), 403, "weights_no_blob", "magic");
  const json shorter = answer_to(cut);
  expect_refusal(shorter, 403, "weights_truncated", "payload_bytes");
  EXPECT_EQ(shorter.value("found", ""), std::to_string(cut.size()));
  EXPECT_EQ(shorter.value("expected", ""), whole);
  const json tiny = answer_to(Bytes(3, std::byte{'x'}));
  expect_refusal(tiny, 403, "weights_truncated", "header");
  EXPECT_EQ(tiny.value("found", ""), "3");

  const json topology = answer_to(signed_blob(10, plain_blob<ThreeVav>()));
  expect_refusal(topology, 422, "weights_topology", "topology_hash");
  EXPECT_EQ(topology.value("expected", ""), "5vav-5fcu-2power");
  const json scope = answer_to(
      signed_with([](BlobHeader& h) { std::string_view("Room 999").copy(h.site_scope.data(), h.site_scope.size()); }));
  expect_refusal(scope, 422, "weights_scope", "site_scope");
  EXPECT_EQ(scope.value("expected", ""), "Room 301");
  EXPECT_EQ(scope.dump().find("999"), std::string::npos) << "nothing of the blob's own text comes back";
  const json cycle = answer_to(signed_with([](BlobHeader& h) {
    h.format_version = blob_version_cycle;
    h.cycle_min = 30;
  }));
  expect_refusal(cycle, 422, "weights_cycle", "cycle_min");
  EXPECT_EQ(cycle.value("found", ""), "30");
  EXPECT_EQ(cycle.value("expected", ""), "18");
  const json version = answer_to(signed_with([](BlobHeader& h) { h.format_version = 9; }));
  expect_refusal(version, 422, "weights_version", "format_version");
  EXPECT_EQ(version.value("found", ""), "9");
  expect_refusal(answer_to(signed_with([](BlobHeader& h) { h.endian_mark ^= 1; })), 422, "weights_architecture",
                 "endian_mark");
  expect_refusal(answer_to(signed_with([](BlobHeader& h) { h.units_hash ^= 1; })), 422, "weights_units", "units_hash");
  expect_refusal(answer_to(signed_with([](BlobHeader& h) { h.digest_kind = 2; })), 422, "weights_damaged",
                 "digest_kind");
  expect_refusal(answer_to(signed_with([](BlobHeader& h) { h.parameters ^= 1; })), 422, "weights_size", "parameters");
  Bytes senseless = plain_blob();
  std::fill_n(senseless.begin() + sizeof(BlobHeader), 16, std::byte{0xFF});
  expect_refusal(answer_to(signed_blob(10, senseless)), 422, "weights_value", "scaler");
  EXPECT_TRUE(inbox_is_empty());
}

TEST_F(PageRefusals, OfHeadsAndPausesNameTheirCode) {
  ASSERT_TRUE(start()) << read("said.txt");
  const auto answer = [this](const std::string& request) { return json::parse(body_of(ask(request)), nullptr, false); };
  const std::size_t longest = WeightBlob<FiveZone>::max_bytes;
  const json large = answer(post_head(longest + 1));
  expect_refusal(large, 413, "weights_too_large");
  EXPECT_EQ(large.value("found", ""), std::to_string(longest + 1));
  EXPECT_EQ(large.value("expected", ""), std::to_string(longest));
  expect_refusal(answer(post_head(0)), 400, "weights_empty");
  expect_refusal(answer(get("/none")), 404, "no_page");
  expect_refusal(answer(get("/weights")), 405, "wrong_method");
  expect_refusal(answer(get("/weights.blob")), 404, "no_weights");
  expect_refusal(answer(get("/trends.json?span=year")), 400, "span_unknown");
  expect_refusal(answer("GET /token HTTP/1.1\r\nHost: evil.example\r\n\r\n"), 421, "host_unknown");
  const auto posted = [&](const std::string& path, const std::string& lines) {
    return answer("POST " + path + " HTTP/1.1\r\nHost: " + host() + "\r\n" + lines + "\r\n");
  };
  const std::string with_token = "X-Airside-Token: " + token + "\r\n";
  expect_refusal(posted("/weights", "Content-Length: 9\r\n"), 403, "token_missing");
  expect_refusal(posted("/weights", with_token + "Origin: http://evil.example\r\n"), 403, "origin_other");
  expect_refusal(posted("/weights", with_token), 411, "length_missing");
  expect_refusal(posted("/release", with_token), 401, "sign_in_operator");
  expect_refusal(posted("/points/sign", with_token), 401, "sign_in_installer");
  expect_refusal(posted("/login", with_token), 400, "sign_in_form");
  expect_refusal(answer(post(plain_blob())), 403, "weights_key", "key_id");
  expect_refusal(answer(post(signed_blob())), 429, "weights_pause");
  fs::remove(folder / "state/status.json");
  expect_refusal(answer(get("/status.json")), 503, "no_status");
  EXPECT_TRUE(inbox_is_empty());
}

TEST_F(PageRefusals, OfOrdersNameTheirCode) {
  Access access;
  const std::string key(64, 'a');
  access.keys.push_back({Role::installer, digest_of_key(key), "tablet"});
  fs::create_directory(folder / "page");
  write_access((folder / "page").string(), access);
  ASSERT_TRUE(start()) << read("said.txt");
  const auto order = [&](const std::string& path, const std::string& body) {
    const std::string request = "POST " + path + " HTTP/1.1\r\nHost: " + host() + "\r\nAuthorization: Bearer " + key +
                                "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    return json::parse(body_of(ask(request)), nullptr, false);
  };
  expect_refusal(order("/release", "soon"), 400, "hours_wrong");
  expect_refusal(order("/hand-back", "x"), 400, "body_unexpected");
  expect_refusal(order("/release", std::string(2000, '4')), 413, "body_too_large");
  expect_refusal(order("/alarms/seen", "none"), 400, "alarm_form");
  expect_refusal(order("/alarms/seen", "99"), 404, "alarm_unknown");
  expect_refusal(order("/points/sign", "one line"), 400, "sign_off_form");
  expect_refusal(order("/points/sign", "room_temp_1\n \n"), 400, "name_form");
  expect_refusal(order("/points/sign", "room_temp_1\nAnn\n"), 404, "point_unknown");
  expect_refusal(order("/points/withdraw", "room_temp_1"), 404, "not_signed");
  fs::remove(folder / "inbox");
  const json away = order("/release", "");
  expect_refusal(away, 503, "inbox_unwritable");
  EXPECT_EQ(away.value("found", ""), "folder not found");
  fs::create_directory(folder / "inbox");
  const json done = order("/release", "4");
  EXPECT_EQ(done.value("status", 0), 202) << done;
  EXPECT_FALSE(done.contains("code")) << "what is done is no refusal";
}

}  // namespace
}  // namespace airside::page
