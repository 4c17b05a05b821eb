// The whole way of weights from one room to the next: learned by a daemon, pulled through its page, signed, pushed
// through another page, taken on trial and confirmed by the daemon there.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/bench.hpp"

namespace airside::page {
namespace {

namespace fs = std::filesystem;
using closed_loop::Bench;
using closed_loop::Child;

/// A room behind Modbus, its daemon's folder, and the page beside it.
class Box {
 public:
  Box(const std::string& name, int days)
      : bench({.name = name, .plant = closed_loop::rc_room(), .expert_days = 1, .days = days}) {
    for (const char* part : {"keys", "inbox"}) fs::create_directories(bench.file(part));
    bench.start_server();
    page = std::make_unique<Child>(
        std::vector<std::string>{bench.program("airside-page"), "--site", bench.file("site.toml"), "--port", "0",
                                 "--ready", bench.file("page.ready")},
        bench.file("page.txt"));
    const double until = closed_loop::now_s() + 30;
    while (read("page.ready").find('\n') == std::string::npos && closed_loop::now_s() < until)
      closed_loop::sleep_s(0.01);
    const std::string where = read("page.ready");
    address = "http://" + where.substr(0, where.find('\n'));
  }
  std::string read(const std::string& name) const {
    std::ifstream in(bench.file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  int airside(std::vector<std::string> words) {
    words.insert(words.begin(), bench.program("airside").string());
    fs::remove(bench.file("said.txt"));
    return Child(words, bench.file("said.txt")).wait(60).value_or(-1);
  }
  nlohmann::json inspected(const std::string& blob) {
    EXPECT_EQ(airside({"blob", "inspect", blob, "--json"}), 0) << said();
    return nlohmann::json::parse(said(), nullptr, false);
  }
  std::string said() const { return read("said.txt"); }
  nlohmann::json status() const { return bench.status(); }

  Bench bench;
  std::unique_ptr<Child> page;
  std::string address;
};

TEST(PulledWeights, TravelFromOneBoxToAnother) {
  Box from("pull_from", 1), to("pull_to", 2);
  const auto teacher = from.bench.start_daemon();
  ASSERT_EQ(teacher->wait(120), 0) << teacher->said();
  const std::string blob = to.bench.file("room.blob");
  ASSERT_EQ(to.airside({"pull", from.address, "-o", blob}), 0) << to.said();
  const auto facts = to.inspected(blob);
  EXPECT_EQ(facts["ok"], true);
  EXPECT_EQ(facts["header"]["key"], "unsigned");
  EXPECT_EQ(facts["header"]["site_scope"], "any site");
  EXPECT_EQ(facts["header"]["created"], "2021-08-02T23:54:00");
  EXPECT_EQ(facts["provenance"],
            "learned by airsided in \"Bench\" (5vav-5fcu-2power) until 2021-08-02T23:54:00: 80 decisions");
  EXPECT_EQ(to.airside({"blob", "diff", from.bench.file("weights.blob"), blob, "--json"}), 0);
  EXPECT_NE(to.said().find("\"identical\":false"), std::string::npos) << "a day of learning shows";

  EXPECT_EQ(to.airside({"push", blob, to.address}), 1) << "as it was pulled, it is nobody's";
  ASSERT_EQ(to.airside({"keygen", "-o", to.bench.file("ann")}), 0) << to.said();
  fs::copy(to.bench.file("ann.pub"), to.bench.file("keys") / "ann.pub");
  const std::string key = to.bench.file("ann.key"), signed_blob = to.bench.file("signed.blob");
  ASSERT_EQ(to.airside({"sign", blob, "--key", key, "-o", signed_blob, "--scope", "Elsewhere"}), 0) << to.said();
  EXPECT_EQ(to.airside({"push", signed_blob, to.address}), 1);
  EXPECT_NE(to.said().find("site_scope"), std::string::npos) << to.said();
  closed_loop::sleep_s(2.1);
  ASSERT_EQ(to.airside({"sign", blob, "--key", key, "-o", signed_blob, "--scope", "Bench"}), 0) << to.said();
  ASSERT_EQ(to.airside({"push", signed_blob, to.address}), 0) << to.said();

  const auto pupil = to.bench.start_daemon();
  ASSERT_EQ(pupil->wait(180), 0) << pupil->said();
  EXPECT_NE(pupil->said().find("taken; on trial"), std::string::npos) << pupil->said();
  EXPECT_EQ(to.status()["pushed_weights"], "confirmed");
  EXPECT_TRUE(fs::is_empty(to.bench.file("inbox")));
  const std::string digest = to.status()["pushed_crc"];
  const auto learned = to.inspected(to.bench.file("state") / "weights.blob");
  const std::string provenance = learned["provenance"];
  EXPECT_NE(provenance.find("; pushed weights " + digest + " confirmed"), std::string::npos) << provenance;
}

TEST(PulledWeights, AreNeverThoseOnTrial) {
  Box box("pull_trial", 1);
  ASSERT_EQ(box.airside({"keygen", "-o", box.bench.file("ann")}), 0) << box.said();
  fs::copy(box.bench.file("ann.pub"), box.bench.file("keys") / "ann.pub");
  const std::string blob = box.bench.file("signed.blob");
  ASSERT_EQ(box.airside({"sign", box.bench.file("weights.blob"), "--key", box.bench.file("ann.key"), "-o", blob}), 0);
  ASSERT_EQ(box.airside({"push", blob, box.address}), 0) << box.said();
  const auto daemon = box.bench.start_daemon();
  ASSERT_EQ(daemon->wait(120), 0) << daemon->said();
  EXPECT_EQ(box.status()["pushed_weights"], "on trial");
  EXPECT_FALSE(fs::exists(box.bench.file("state") / "weights.blob"));
  EXPECT_EQ(box.airside({"pull", box.address, "-o", box.bench.file("out.blob")}), 1);
  EXPECT_NE(box.said().find("404"), std::string::npos) << box.said();
}

}  // namespace
}  // namespace airside::page
