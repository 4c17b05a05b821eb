// The page of the published method's studies: peers of another harness beside the runs, and runs kept in one file.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "support/program.hpp"
#include "tools/study/method/claims.hpp"
#include "tools/study/method/peer_rows.hpp"
#include "tools/study/method/report.hpp"
#include "tools/study/method/runs_file.hpp"

namespace airside::tools {
namespace {

using nlohmann::json;

class MethodReport : public testing::Test {
 protected:
  MethodReport() { study_.folder = (folder_.path() / "runs").string(); }

  std::string write(const std::string& name, const std::string& text) const {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return path.string();
  }
  /// A run as the program writes it, with these figures.
  void add_run(const std::string& row, const std::string& room, int seed, const json& figures,
               const std::vector<double>& days) const {
    const json run{{"row", row},         {"room", room},          {"seed", seed}, {"study", study_.facts()},
                   {"figures", figures}, {"daily_dae_degc", days}};
    write("runs/" + row + "_" + room + "_" + std::to_string(seed) + ".json", run.dump(1) + "\n");
  }
  std::string peers_file(const char* study, const json& rows, const json& claims) const {
    return write(std::string(study) + ".json", json{{"study", study}, {"rows", rows}, {"claims", claims}}.dump());
  }
  static json condition(int claim, const char* text, const json& holds) {
    return {{"claim", claim}, {"condition", text}, {"holds", holds}};
  }
  static const ClaimVerdict& claim(const std::vector<ClaimVerdict>& all, int number) {
    return *std::ranges::find(all, number, &ClaimVerdict::number);
  }
  std::string refusal_of(const std::string& text) const {
    PeerRows rows;
    try {
      add_peer_rows(rows, write("bad.json", text));
    } catch (const hal::InputError& e) {
      return e.what();
    }
    return "";
  }

  TemporaryFolder folder_, scratch_;
  MethodStudy study_;
};

TEST_F(MethodReport, ClaimsOnOtherLearnersAreJudgedByTheirOwnConditions) {
  for (const int seed : {1, 2}) {
    add_run("paper", "301-real", seed, {{"dae_degc", 0.1}}, {0.1, 0.1});
    add_run("pid", "301-real", seed, {{"dae_degc", 0.2}}, {0.2, 0.2});
    add_run("expert", "301-real", seed, {{"dae_degc", 1.5}}, {1.5, 1.5});
  }
  const MethodResults results = MethodResults::read(study_);
  EXPECT_EQ(claim(judge_claims(results), 4).state, ClaimState::partly) << "other learners are not among the runs";
  EXPECT_EQ(claim(judge_claims(results), 16).state, ClaimState::elsewhere);

  PeerRows peers;
  add_peer_rows(peers,
                peers_file("control", json::array({{{"method", "osln"}, {"runs", 5}, {"dae_degc", 0.3}}}),
                           json::array({condition(4, "DARV: ed < osln", true), condition(16, "DAE: ed lowest", false),
                                        condition(16, "time: ed lowest", true)})));
  const auto with = judge_claims(results, peers);
  EXPECT_EQ(claim(with, 4).state, ClaimState::reproduced) << claim(with, 4).ours;
  EXPECT_NE(claim(with, 4).ours.find("DARV: ed < osln: yes"), std::string::npos) << claim(with, 4).ours;
  EXPECT_EQ(claim(with, 16).state, ClaimState::partly);
  EXPECT_EQ(claim(with, 11).state, ClaimState::elsewhere) << "nothing was said of it";

  PeerRows unknown;
  add_peer_rows(unknown, peers_file("transfer", json::array(), json::array({condition(4, "first days", nullptr)})));
  EXPECT_EQ(claim(judge_claims(results, unknown), 4).state, ClaimState::partly) << "a condition is not known";
}

TEST_F(MethodReport, ShowsWhatThereIsAndSaysWhatIsNot) {
  for (const int seed : {1, 2}) {
    const double more = 0.02 * seed;
    add_run("paper", "301-real", seed, {{"dae_degc", 0.1 + more}, {"darv_degc", 0.3}}, {0.2 + more, 0.1});
    add_run("dynamic-5", "701-real", seed, {{"dae_degc", 0.1}, {"saved_area_degch", 40.0}}, {0.2, 0.1});
  }
  const MethodResults results = MethodResults::read(study_);
  const ReportInput page = method_report(study_, results, {}, judge_claims(results), "airside study all");
  std::vector<std::string> titles;
  for (const ReportBlock& block : page.blocks)
    titles.push_back(std::visit([](const auto& b) { return b.title; }, block));
  const auto has = [&titles](const char* part) {
    return std::ranges::any_of(titles, [part](const std::string& t) { return t.find(part) != std::string::npos; });
  };
  for (const char* there : {"figure 7", "figure 8", "figure 10", "figure 11", "figure 12", "What these runs lack"})
    EXPECT_TRUE(has(there)) << there;
  for (const char* missing : {"figure 9", "figure 13", "table VII"}) EXPECT_FALSE(has(missing)) << missing;
  EXPECT_NE(page.headline.find("2 here, so the verdicts are provisional"), std::string::npos) << page.headline;

  const auto& line = std::get<LineChart>(page.blocks[1]);
  ASSERT_EQ(line.series.size(), 1U);
  EXPECT_NEAR(line.series[0].y[0], 0.23, 1e-12) << "the mean of both seeds";
  EXPECT_EQ(line.unit, "K");
  for (const ReportBlock& block : page.blocks) {
    const auto* table = std::get_if<ReportTable>(&block);
    if (table == nullptr) continue;
    for (const TableColumn& c : table->columns) EXPECT_EQ((c.name + c.unit).find("°C"), std::string::npos) << c.name;
  }

  PeerRows peers;
  add_peer_rows(peers, peers_file("control",
                                  json::array({{{"method", "osln"},
                                                {"runs", 5},
                                                {"dae_degc", 0.3},
                                                {"dae_degc_sd", 0.01},
                                                {"decision_s", 0.002},
                                                {"daily_dae_degc", {0.5, 0.4}}}}),
                                  json::array()));
  const ReportInput beside = method_report(study_, results, peers, judge_claims(results, peers), "");
  EXPECT_EQ(std::get<LineChart>(beside.blocks[1]).series.size(), 2U);
  const auto table = std::ranges::find_if(beside.blocks, [](const ReportBlock& b) {
    return std::holds_alternative<ReportTable>(b) && std::get<ReportTable>(b).title.find("VII") != std::string::npos;
  });
  ASSERT_NE(table, beside.blocks.end());
  EXPECT_EQ(std::get<ReportTable>(*table).rows[0].cells.back().value, 2.0) << "ms";
}

TEST_F(MethodReport, RefusesWhatIsNoOutputOfThePeers) {
  EXPECT_NE(refusal_of("[]").find("study: found nothing"), std::string::npos) << refusal_of("[]");
  const std::string other = R"({"study": "rooms"})", no_rows = R"({"study": "control", "claims": []})",
                    no_method = R"({"study": "control", "rows": [{"runs": 1}], "claims": []})",
                    no_claim = R"({"study": "control", "rows": [], "claims": [{"claim": "four"}]})";
  EXPECT_NE(refusal_of(other).find("found rooms; expected control or transfer"), std::string::npos);
  EXPECT_NE(refusal_of(no_rows).find("rows: found no list"), std::string::npos);
  EXPECT_NE(refusal_of(no_method).find("the name of a method"), std::string::npos);
  EXPECT_NE(refusal_of(no_claim).find("claims: found"), std::string::npos);
  PeerRows twice;
  const std::string file = peers_file("control", json::array({{{"method", "ed"}, {"runs", 1}}}), json::array());
  add_peer_rows(twice, file);
  EXPECT_THROW(add_peer_rows(twice, file), hal::InputError);
}

TEST_F(MethodReport, RunsThatWereKeptInOneFileAreTheSameRuns) {
  add_run("paper", "301-real", 1, {{"dae_degc", 0.1}}, {0.1});
  add_run("dynamic-5", "701-real", 2, {{"dae_degc", 0.25}}, {0.3, 0.2});
  const std::string file = (folder_.path() / "kept.json").string();
  EXPECT_EQ(keep_runs(study_, file), 2);
  MethodStudy other = study_;
  other.folder = (folder_.path() / "others").string();
  EXPECT_EQ(take_runs(other, file), 2);
  EXPECT_EQ(take_runs(other, file), 0) << "the folder has them";
  for (const char* name : {"paper_301-real_1.json", "dynamic-5_701-real_2.json"})
    EXPECT_EQ(text_of_file(fs::path(other.folder) / name), text_of_file(fs::path(study_.folder) / name));

  json outside = json::parse(text_of_file(file));
  outside["runs"][0]["room"] = "../../etc";
  const std::string bad = write("bad.json", outside.dump());
  other.folder = (folder_.path() / "nothing").string();
  EXPECT_THROW(take_runs(other, bad), hal::InputError);
  EXPECT_FALSE(fs::exists(other.folder)) << "nothing is half-taken";
  other.days = 3;
  EXPECT_THROW(take_runs(other, file), hal::InputError) << "runs of another study";
  EXPECT_FALSE(fs::exists(other.folder));
}

TEST_F(MethodReport, AStudyGoesOnFromAKeptFileAndMakesWeightsAgain) {
  const auto study = [&](std::vector<std::string> words, std::vector<std::string> more) {
    words.insert(words.begin(), "study");
    for (const char* word : {"--days", "1", "--pretrain-days", "2", "--operated-days", "2", "--steps", "5", "--seeds",
                             "1", "--summer-days", "1", "--winter-days", "1", "-o"})
      words.emplace_back(word);
    words.insert(words.end(), more.begin(), more.end());
    return run_program("airside", words, folder_.path(), scratch_.path(), 500);
  };
  const Outcome first = study({"method", "--tables", "neighbours"}, {"first", "--keep", "kept.json"});
  ASSERT_EQ(first.code, 0) << first.err;

  json kept = json::parse(text_of_file(folder_.path() / "kept.json"));
  auto& runs = kept["runs"];
  const auto gone =
      std::ranges::find_if(runs, [](const json& r) { return r["row"] == "room-to-room" && r["room"] == "401-real"; });
  ASSERT_NE(gone, runs.end());
  runs.erase(gone);
  write("kept.json", kept.dump());
  const Outcome again = study({"method", "--tables", "neighbours"}, {"second", "--from", "kept.json"});
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.err.find("2 runs"), std::string::npos) << "one row and its weights: " << again.err;
  EXPECT_EQ(text_of_file(folder_.path() / "second" / "room-to-room_401-real_1.json"),
            text_of_file(folder_.path() / "first" / "room-to-room_401-real_1.json"));

  const Outcome page = study({"all"}, {"second", "--report-only"});
  ASSERT_EQ(page.code, 0) << page.err;
  EXPECT_NE(page.out.find("| 24 "), std::string::npos) << page.out;
  EXPECT_NE(text_of_file(folder_.path() / "second" / "report" / "index.html").find("printed figure 13"),
            std::string::npos);
}

}  // namespace
}  // namespace airside::tools
