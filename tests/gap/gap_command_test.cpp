// airside gap as a person runs it: logs and a site file in, verdict, report, patch and ledger out; and what it says
// when it cannot.

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>

#include "gap/gap_desk.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "support/child.hpp"
#include "tools/gap/model/patched_model.hpp"

namespace airside::tools::gap {
namespace {

TEST(GapCommand, NamesWhatIsHiddenReportsPatchesTheRoomAndTakesThePatchBack) {
  const GapDesk desk;
  const Outcome o = desk.run(std::string(usual_words) + " --out out --apply patched.json --price 0.25 --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json j = json::parse(o.out);  // one object and nothing else
  ASSERT_EQ(j["verdict"], "named") << j.dump(1);
  ASSERT_EQ(j["effects"].size(), 1U);
  const json& effect = j["effects"][0];
  EXPECT_EQ(effect["id"], "vav_flow@2");
  EXPECT_EQ(effect["place"], "2");
  EXPECT_NEAR(effect["magnitude"].get<double>(), 0.5, 0.1);
  EXPECT_LT(effect["interval"][0].get<double>(), effect["magnitude"].get<double>());
  EXPECT_GT(effect["interval"][1].get<double>(), effect["magnitude"].get<double>());
  EXPECT_GT(effect["gain_over_limit"].get<double>(), 1);
  EXPECT_FALSE(j["stand_in"]);
  EXPECT_EQ(j["locked_days"]["days"], 2);
  EXPECT_LT(j["locked_days"]["after"]["temp_rmse_k"].get<double>(),
            0.5 * j["locked_days"]["before"]["temp_rmse_k"].get<double>());
  EXPECT_EQ(j, desk.read("out/gap.json"));
  EXPECT_TRUE(j["retraining"].is_null());
  // Half the flow of a box saves a little cooling, and the sentence ends with what to do.
  const json& energy = j["energy"].at(0);
  EXPECT_EQ(energy["id"], "vav_flow@2");
  EXPECT_LT(energy["kwh_per_day"].get<double>(), 0) << energy;
  EXPECT_NEAR(energy["kwh_per_day"].get<double>(), energy["by_meter"]["power_1_kw"].get<double>(), 1e-9);
  EXPECT_NEAR(energy["cost_per_day"]["cost"].get<double>(), 0.25 * energy["kwh_per_day"].get<double>(), 1e-9);
  EXPECT_NE(j["sentence"].get<std::string>().find("to confirm it on site: hood at the diffuser"), std::string::npos);
  // The curve that the page draws as measured minus simulated; nothing is measured of a value that never came.
  const json& curve = j["after_curve"];
  EXPECT_EQ(curve["from"], "2021-07-09T00:00:00");
  ASSERT_EQ(curve["channels"]["room_temp_2_degc"].size(), 8U * 48);
  for (const json& value : curve["channels"]["room_temp_2_degc"]) EXPECT_NEAR(value.get<double>(), 25, 8);
  for (const auto& file : j["files"]) EXPECT_TRUE(fs::exists(desk.path(file.get<std::string>()))) << file;

  // The page: whole, on its own, with everything that was promised.
  const std::string page = text_of_file(desk.path("out/index.html"));
  for (const char* promised :
       {"<h1>Flow of box 2 is not what its controller believes</h1>", "verdict: named", "To confirm it on site",
        "Guideline 14", "a wrong model can pass", "The 2 days that were locked away", "The ledger",
        "gain on the locked days: predicted, came<span class=\"unit\">2 ln likelihood ratio</span>",
        ">flow of box 2 is not what its controller believes<", "hood at the diffuser", "with what was found",
        "In which weather", "What else could explain it", "</html>"}) {
    EXPECT_NE(page.find(promised), std::string::npos) << promised;
  }
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
  EXPECT_EQ(page.find("vav_flow@"), std::string::npos) << "words, not ids";

  // The patched room is a room, and differs in the flow of one box by about what was found.
  const sim::RcRoom patched = sim::load_room(desk.path("patched.json").string());
  const json ledger = desk.read("out/ledger.json");
  EXPECT_EQ(desk.read("patched.json.ledger.json"), ledger);
  const json& entry = ledger["entries"].back();
  EXPECT_EQ(entry["role"], "finding");
  EXPECT_EQ(entry["id"], "vav_flow@2");
  EXPECT_EQ(entry["edits"][0]["where"], "vav_flow_calibration");
  EXPECT_EQ(entry["edits"][0]["after"][1], patched.vav_flow_calibration[1]);
  EXPECT_NEAR(patched.vav_flow_calibration[1], 0.5, 0.1);
  EXPECT_EQ(ledger["digest_after"], model_digest(desk.read("patched.json")));
  json again = json{{"base", "rc"}, {"vavs", 3}, {"fcus", 0}, {"powers", 1}};
  EXPECT_EQ(ledger["digest_before"], model_digest(again));
  again.merge_patch(desk.read("out/twin-patch.json"));
  EXPECT_EQ(again, desk.read("patched.json"));

  ASSERT_EQ(desk.run("revert out/ledger.json patched.json -o before.json").code, 0);
  EXPECT_EQ(desk.read("before.json").dump(), (json{{"base", "rc"}, {"vavs", 3}, {"fcus", 0}, {"powers", 1}}.dump()));
  const Outcome told = desk.run("revert out/ledger.json patched.json -o before.json --json");
  EXPECT_EQ(json::parse(told.out, nullptr, false),
            (json{{"model", "before.json"}, {"digest", model_digest(desk.read("before.json"))}}))
      << told.out << told.err;
  // Back twice, and back from a model that somebody changed, is refused.
  EXPECT_EQ(complaint_in(desk.run("revert out/ledger.json before.json -o x.json").err).remedy,
            "nothing has to be taken back");
  json edited = desk.read("patched.json");
  edited["chiller_cop"] = 3.0;
  desk.write("edited.json", edited.dump());
  EXPECT_NE(complaint_in(desk.run("revert out/ledger.json edited.json -o x.json").err).expected.find("patched model"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(desk.path("x.json")));
}

/// Names in the folder of the command that are of its output.
std::set<std::string> outputs(const GapDesk& desk) {
  std::set<std::string> found = desk.names();
  std::erase_if(found, [](const std::string& name) { return !name.starts_with("out"); });
  return found;
}

TEST(GapCommand, WithoutAReferencePeriodSaysSoAndLeavesTheTwinsOwnParameters) {
  const GapDesk desk;
  const Outcome o = desk.run("run --site site.toml --measured measured.csv --no-reference --effects effects --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json j = json::parse(o.out);
  EXPECT_TRUE(j["reference"].is_null());
  EXPECT_EQ(j["clean_up"].size(), 1U) << "one log";
  EXPECT_NE(j["sentence"].get<std::string>().find("there was no reference period"), std::string::npos);
  EXPECT_EQ(j["ranking"][0], "vav_flow@2") << "a box at half its flow";
  // As a parameter its flow would be many standard deviations of its prior off.
  const bool found = !j["effects"].empty() && j["effects"][0]["id"] == "vav_flow@2";
  const bool far = !j["far_parameters"].empty() && j["far_parameters"][0]["id"] == "vav_flow@2";
  EXPECT_TRUE(found || far) << j["sentence"];
  for (const json& p : j["far_parameters"]) EXPECT_GE(std::abs(p["prior_sds"].get<double>()), 2) << p;
  const std::string page = text_of_file(desk.path("gap-report/index.html"));
  EXPECT_NE(page.find("none: the twin"), std::string::npos);
  // What was made can be gone on with: more days need no reference either.
  EXPECT_EQ(j["inputs"]["reference"], json());
  EXPECT_EQ(j["inputs"]["reference_days"], 0);
}

TEST(GapCommand, LeavesItsFolderWholeOrNotAtAllWhereItIsInterrupted) {
  const GapDesk desk;
  const TemporaryFolder said;
  ASSERT_EQ(desk.run(std::string(usual_words) + " --out out").code, 0);
  const std::set<std::string> whole = outputs(desk);
  for (const char* name : {"out/gap.json", "out/index.html", "out/ledger.json", "out/twin-patch.json"}) {
    EXPECT_TRUE(whole.contains(name)) << name;
  }
  for (const int number : {SIGINT, SIGTERM, SIGKILL}) {
    fs::remove_all(desk.path("out"));
    closed_loop::Child run(
        {"/bin/sh", "-c",
         "cd " + desk.path("").string() + " && exec " AIRSIDE_BIN_DIR "/airside gap " + usual_words + " --out out"},
        said.path() / "said");
    const auto has_begun = [&] {
      const auto entries = fs::directory_iterator(desk.path(""));
      return std::any_of(begin(entries), end(entries),
                         [](const auto& entry) { return entry.path().filename().string().starts_with("out"); });
    };
    while (run.running() && !has_begun()) closed_loop::sleep_s(0.0005);
    run.signal(number);
    run.wait(60);
    const std::set<std::string> left = outputs(desk);
    if (fs::exists(desk.path("out"))) {
      EXPECT_EQ(left, whole) << number << run.said();
    } else {
      EXPECT_TRUE(left.empty() || number == SIGKILL) << *left.begin();
    }
  }
  ASSERT_EQ(desk.run(std::string(usual_words) + " --out out").code, 0);
  EXPECT_EQ(outputs(desk), whole) << "what the killed one has left is removed";
}

TEST(GapCommand, LeavesTheTwinAloneWhereNothingIsMissing) {
  const GapDesk desk(6);
  fs::create_directory(desk.path("out"));
  for (const char* name : {"out/twin-patch.json", "out/notes.txt"}) desk.write(name, "of before");
  // The first days of the reference log are the reference: nothing is hidden in the days after them.
  const Outcome o = desk.run(
      "run --site site.toml --measured reference.csv --reference-days 3 --effects effects --out out --apply p.json");
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_NE(o.out.find("locked days (1)"), std::string::npos) << o.out;
  EXPECT_EQ(complaint_in(o.err).place, "airside: --apply p.json") << o.err;
  EXPECT_NE(complaint_in(o.err).remedy.find("left as it is"), std::string::npos);
  EXPECT_FALSE(fs::exists(desk.path("p.json")));
  EXPECT_FALSE(fs::exists(desk.path("out/twin-patch.json"))) << "of an earlier run, which found something";
  EXPECT_TRUE(fs::exists(desk.path("out/notes.txt")));
  EXPECT_NE(desk.read("out/gap.json")["verdict"], "named");
}

TEST(GapCommand, RefusesALogWithItsTableAndLeavesNothingBehind) {
  const GapDesk desk(4);
  desk.exchange("measured.csv", "room_temp_2_degc", "vav_on_1");
  const auto before = desk.names();
  for (const char* form : {"", "run "}) {
    const Outcome o = desk.run(form + std::string(usual_words) + " --out out --apply p.json --json");
    EXPECT_EQ(o.code, 1);
    EXPECT_EQ(o.out, "");
    EXPECT_NE(o.err.find("clean-up of measured.csv"), std::string::npos) << o.err;
    EXPECT_NE(o.err.find("refused   swapped"), std::string::npos) << o.err;
    EXPECT_EQ(complaint_in(o.err).expected, "each column under its own name") << o.err;
    EXPECT_EQ(desk.names(), before);
  }
}

struct BadRequest {
  const char *words, *place, *part;  ///< part of the complaint
  int code = 1;
};

TEST(GapCommand, SaysWhatIsMissingAndWhatToDo) {
  const GapDesk desk(4);
  desk.write("bare.toml", "[site]\nname = \"Bare\"\ntopology = \"3vav-0fcu-1power\"\n");
  desk.write("file", "x");
  const auto before = desk.names();
  const std::vector<BadRequest> requests{
      {"", "", "--measured", 2},
      {"--site site.toml --reference reference.csv", "", "--measured", 2},
      {"--site site.toml --measured measured.csv", "--reference", "as the twin describes"},
      {"--site site.toml --measured measured.csv --reference reference.csv --reference-days 3", "--reference", "one "},
      {"--site site.toml --measured measured.csv --reference reference.csv --no-reference", "--reference",
       "--no-reference beside it"},
      {"--site site.toml --measured measured.csv --reference-days 1", "", "1 not in range", 2},
      {"--site bare.toml --measured measured.csv --reference reference.csv", "--twin", "--plant rc"},
      {"--site bare.toml --measured measured.csv --reference reference.csv --plant rc", "--weather", "sun, humidity"},
      {"--site site.toml --measured measured.csv --reference reference.csv --twin x.idf", "--twin x.idf", "epJSON"},
      {"--site site.toml --measured measured.csv --reference reference.csv --twin x.epJSON --room 301",
       "--twin x.epJSON", "one model"},
      {"--site site.toml --measured measured.csv --reference reference.csv --plant rc --room 302", "room", "302"},
      {"--site site.toml --measured measured.csv --reference no.csv", "no.csv", "no file"},
      {"--site site.toml --measured measured.csv --reference measured.csv", "measured.csv", "reference period"},
      {"--site site.toml --measured measured.csv --reference reference.csv --out file", "--out file", "a file"},
      {"--site site.toml --measured measured.csv --reference reference.csv --apply effects", "--apply effects",
       "a folder"},
      {"--site site.toml --measured measured.csv --reference reference.csv --keep-run k", "--keep-run k", "RC room"},
      {"--site site.toml effects", "", "excludes", 2},
      {"--jobs 2 score a b", "", "excludes", 2},
      {"revert no.json no.json -o x.json", "no.json", "JSON"},
  };
  for (const BadRequest& r : requests) {
    const Outcome o = desk.run(r.words);
    EXPECT_EQ(o.code, r.code) << r.words << "\n" << o.err;
    EXPECT_EQ(o.out, "") << r.words;
    EXPECT_NE(o.err.find(r.place), std::string::npos) << r.words << "\n" << o.err;
    EXPECT_NE(o.err.find(r.part), std::string::npos) << r.words << "\n" << o.err;
    EXPECT_EQ(desk.names(), before) << r.words;
  }
}

TEST(GapCommand, GivesACaseWithABadLogAVerdictOfItsOwn) {
  const GapDesk desk(4);
  desk.exchange("measured.csv", "room_temp_2_degc", "vav_on_1");
  fs::create_directories(desk.path("cases/case-1"));
  desk.write("cases/case-1/case.json", R"({"format": 1, "engine": "rc", "model": "rc", "weather": "../../w.epw",
    "reference": "../../reference.csv", "measured": "../../measured.csv", "topology": "3vav-0fcu-1power"})");
  desk.write("key.json", R"({"format": 1, "seed": 1, "cases": {"case-1": {"set": "null", "engine": "rc"}}})");
  const Outcome o = desk.run("run-cases cases -o verdicts.json --effects effects --json");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(json::parse(o.out)["count"], (json{{"refused", 1}}));
  const json verdict = desk.read("verdicts.json")["verdicts"][0];
  EXPECT_EQ(verdict["verdict"], "refused");
  EXPECT_NE(verdict["reason"].get<std::string>().find("swapped"), std::string::npos);
  const Outcome score = desk.run("score verdicts.json key.json --json");
  ASSERT_EQ(score.code, 0) << score.err;
  const json scored = json::parse(score.out);
  ASSERT_FALSE(scored["sets"].empty());
  for (const json& set : scored["sets"]) EXPECT_EQ(set["refused"], set["set"] == "null" ? 1 : 0);

  // A run that was ended goes on: what is known stays as it is.
  json known = desk.read("verdicts.json");
  known["verdicts"][0]["reason"] = "as it was";
  desk.write("verdicts.json", known.dump());
  fs::copy(desk.path("cases/case-1"), desk.path("cases/case-2"));
  const Outcome on = desk.run("run-cases cases -o verdicts.json --effects effects --continue --json");
  ASSERT_EQ(on.code, 0) << on.err;
  EXPECT_EQ(json::parse(on.out)["count"], (json{{"refused", 2}}));
  const json both = desk.read("verdicts.json")["verdicts"];
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0]["reason"], "as it was");
  EXPECT_NE(both[1]["reason"].get<std::string>().find("swapped"), std::string::npos);
  desk.write("other.json", R"({"verdicts": [{"case": "case-9"}]})");
  const Outcome other = desk.run("run-cases cases -o other.json --effects effects --continue");
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.err.find("case-9"), std::string::npos) << other.err;
}

TEST(PatchedModel, ReversePatchGivesBackEveryValue) {
  const json model = json::parse(R"({"A": {"a": {"x": 1.10, "y": [1, 2], "keep": "k"}, "b": {"z": true}}, "B": {}})");
  const json patch = json::parse(
      R"({"A": {"a": {"x": 2.5, "y": [9], "new": 3}, "c": {"deep": {"er": 1}}, "b": null}, "C": {"n": {"m": 1}}})");
  json now = model;
  now.merge_patch(patch);
  ASSERT_NE(now, model);
  now.merge_patch(reverse_patch(model, patch));
  EXPECT_EQ(now.dump(), model.dump());
}

TEST(PatchedModel, WritesARoomFileThatReadsBackToTheChangedRoom) {
  const auto effects = sim::load_effects(sim::find_effects());
  const auto at = [&](const char* name, int place, double m) {
    const auto found = std::ranges::find(effects, name, &sim::Effect::name);
    return sim::EffectChange{{&*found, place}, m};
  };
  const sim::RcRoom room = sim::load_room("301");
  const Changes changes{at("vav_flow", 2, 1.0 / 3), at("solar_gain", 2, 0.7), at("vav_flow", 2, 0.9),
                        at("room_sensor_bias", 0, 0.5)};
  const PatchedModel patched = patched_room({{"base", "301"}}, room, changes);
  const sim::RcRoom read = sim::parse_room(patched.after.dump(), "patched", "301");
  const sim::RcRoom wanted = sim::changed_room(room, changes);
  for (const sim::RoomField& field : sim::room_fields()) {
    const auto value = [&field](const sim::RcRoom& r) {
      const auto* one = std::get_if<sim::ScalarField>(&field.member);
      return one ? std::vector<double>{r.*(*one)} : r.*std::get<sim::ListField>(field.member);
    };
    EXPECT_EQ(value(read), value(wanted)) << field.name;
  }
  EXPECT_EQ(patched.changes[2].edits.at(0).before[2].get<double>(), 1.0 / 3 * room.vav_flow_calibration[2]);
  // A sensor is no part of a room's file: the ledger must say so.
  EXPECT_TRUE(patched.changes[3].edits.empty());
  ASSERT_EQ(patched.changes[3].beside.size(), 1U);
  EXPECT_EQ(patched.changes[3].beside[0], "sensor room_temp 1: +0.5");
}

TEST(PatchedModel, PatchesTheTwinWithinTheSchemaAndBack) {
  if (!sim::have_energyplus()) {
    GTEST_SKIP()
        << "\n*** EnergyPlus is not installed: run tools/setup, or set AIRSIDE_VENV. This test checked nothing. "
           "***";
  }
  const auto effects = sim::load_effects(sim::find_effects());
  Changes changes;
  for (const sim::Effect& effect : effects) {
    if (effect.on_energyplus)
      changes.push_back({{&effect, effect.place == sim::PlaceKind::facade ? 2 : 0}, effect.probe[1]});
  }
  const json twin = sim::read_json(sim::find_models() / "twin.epJSON");
  const PatchedModel patched = patched_energyplus(twin, {}, changes);
  EXPECT_NO_THROW(check_patched_energyplus(patched, "twin"));
  EXPECT_NE(patched.after, twin);
  json back = patched.after;
  back.merge_patch(patched.reverse);
  EXPECT_EQ(back.dump(), twin.dump());
  // Every change is either in the model or said to be beside it, and each edit starts where the one before left off.
  std::map<std::string, json> last;
  for (const PatchedChange& c : patched.changes) {
    EXPECT_FALSE(c.edits.empty() && c.beside.empty()) << c.change.at.id();
    for (const ModelEdit& e : c.edits) {
      EXPECT_TRUE(!last.contains(e.where) || last[e.where] == e.before) << e.where;
      last[e.where] = e.after;
    }
  }
  EXPECT_GT(last.size(), 20U);
  // The engine would swallow a misspelt field; the check does not.
  PatchedModel wrong = patched;
  wrong.patch["Material"]["x"]["conductivty"] = 1;
  EXPECT_THROW(check_patched_energyplus(wrong, "twin"), hal::InputError);
}

}  // namespace
}  // namespace airside::tools::gap
