// What a person needs to know of a run, and what could go wrong with it, said by the host's program unasked.

#include <nlohmann/json.hpp>

#include "input/program_desk.hpp"
#include "sim/energyplus/install.hpp"

namespace airside {
namespace {

using nlohmann::json;

constexpr const char* no_engine = "AIRSIDE_ENERGYPLUS=/nonexistent ";
constexpr const char* own_twin = "pretrain --plant energyplus --days 2 --updates 1 -o x.blob --json --twin own.epJSON";

json object_of(const Outcome& o) {
  json j = json::parse(o.out, nullptr, false);
  EXPECT_TRUE(j.is_object()) << o.out << o.err;
  return j.is_object() ? j : json::object();
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// sim/models/twin.epJSON as a model of the user's own.
json own_model(const Desk& desk) {
  const json model = json::parse(text_of_file(sim::find_models() / "twin.epJSON"));
  desk.write("own.epJSON", model.dump());
  return model;
}

// ---- Twins

TEST(TwinOfTheCommandLine, GetsNoPatchOfABuiltInRoom) {
  if (!sim::have_energyplus()) GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed; run tools/setup";
  const Desk desk;
  own_model(desk);
  const std::string plain = object_of(desk.run("airside", Desk::split(own_twin))).value("plant", "");
  EXPECT_TRUE(has(plain, "EnergyPlus 25.2, twin (own.epJSON), weather ")) << plain;
  const std::string habits =
      object_of(desk.run("airside", Desk::split(std::string(own_twin) + " --room 402"))).value("plant", "");
  EXPECT_TRUE(has(habits, "twin with the habits of room 402 (own.epJSON), weather ")) << habits;
}

TEST(Check, RefusesATwinThatLacksWhatARunDrives) {
  const Desk desk;
  json model = own_model(desk);
  const auto refused = [&](const json& changed, const std::string& words) {
    desk.write("m.epJSON", changed.dump());
    const Outcome o = desk.shell(std::string(no_engine) + "exec $airside check --twin m.epJSON");
    EXPECT_EQ(o.code, 1) << o.out;
    EXPECT_TRUE(has(o.out, words)) << o.out;
  };
  const auto without = [&model](const char* type, const char* name) {
    json changed = model;
    changed[type].erase(name);
    return changed;
  };
  refused(without("Zone", "Interior 1"), "no 'Interior 1'");
  refused(without("Schedule:Constant", "VAV 3 On"), "no 'VAV 3 On'");
  refused(without("Schedule:Constant", "Supply Air Setpoint"), "no 'Supply Air Setpoint'");
  std::string text = model.dump();
  for (std::size_t at = 0; (at = text.find("AHU Supply Fan Outlet", at)) != std::string::npos;) {
    text.replace(at, 3, "RTU");
  }
  refused(json::parse(text), "no object that names the node 'AHU Supply Fan Outlet'");
  const Outcome whole = desk.shell(std::string(no_engine) + "exec $airside check --twin own.epJSON --json");
  EXPECT_EQ(whole.code, 0) << whole.out;
  EXPECT_TRUE(has(object_of(whole)["warnings"].dump(), "cannot run on this machine")) << whole.out;
}

TEST(Check, RefusesATwinThatItsSiteCannotHave) {
  const Desk desk;
  own_model(desk);
  desk.site();
  const std::string site = text_of_file(desk.path("site.toml"));
  const auto refused = [&](const std::string& twin, const std::string& words) {
    desk.write("site.toml", site + "[twin]\n" + twin + "\n");
    const Outcome o = desk.run("airside", {"check", "site.toml"});
    EXPECT_EQ(o.code, 1) << twin << o.out;
    EXPECT_TRUE(has(o.out, words)) << o.out;
  };
  refused("model = \"none.epJSON\"", "none.epJSON: found no readable file");
  refused("model = \"own.epJSON\"\nweather = \"none.epw\"", "none.epw: found no readable file");
  refused("model = \"rc\"\npatches = [\"p.json\"]", "patches on model = \"rc\"");
  desk.weather();
  desk.set_column("w.epw", 11, 7, "dew");  // the engine alone reads the dew point
  refused("model = \"own.epJSON\"\nweather = \"w.epw\"", "column 8");
  desk.make("init other --topology 3vav-0fcu-1power");
  desk.write("other/site.toml", text_of_file(desk.path("other/site.toml")) + "[twin]\nmodel = \"../own.epJSON\"\n");
  const Outcome o = desk.run("airside", {"check", "other/site.toml"});
  EXPECT_EQ(o.code, 1);
  EXPECT_TRUE(has(o.out, "an epJSON twin of a site of topology 3vav-0fcu-1power")) << o.out;
}

TEST(AnIdf, IsConvertedByTheCommandThatTheComplaintNames) {
  if (!sim::have_energyplus()) GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed; run tools/setup";
  const Desk desk;
  own_model(desk);
  const std::string engine = (sim::find_energyplus().folder / "energyplus").string();
  ASSERT_EQ(desk.run(engine, {"--convert-only", "own.epJSON"}).code, 0);
  fs::remove(desk.path("own.epJSON"));
  ASSERT_TRUE(fs::exists(desk.path("own.idf")));
  const Outcome foreign = desk.run("airside", {"check", "--twin", "own.idf"});
  EXPECT_EQ(foreign.code, 0) << foreign.out << foreign.err;
  EXPECT_TRUE(has(foreign.out, "adopt    own.idf: air loop")) << foreign.out;
  EXPECT_FALSE(fs::exists(desk.path("own.epJSON"))) << "nothing is written";
  const Outcome lost = desk.run("airside", {"check", "--twin", "own.idf", "--air-loop", "none"});
  EXPECT_EQ(lost.code, 1);
  EXPECT_TRUE(has(lost.out, "an air loop of the model")) << lost.out;
  const Outcome o = desk.run("airside", {"check", "--twin", "own.idf", "--patch", "none.json"});
  EXPECT_EQ(o.code, 1);
  const Said said = complaint_in(o.out);
  const std::size_t begin = said.remedy.find('"'), end = said.remedy.find('"', begin + 1);
  ASSERT_NE(end, std::string::npos) << o.out;
  ASSERT_EQ(desk.shell(said.remedy.substr(begin + 1, end - begin - 1)).code, 0) << said.remedy;
  ASSERT_TRUE(has(said.remedy, "own.epJSON")) << said.remedy;
  const Outcome again = desk.run("airside", {"check", "--twin", "own.epJSON"});
  EXPECT_EQ(again.code, 0) << again.out;
}

// ---- Warnings

std::vector<std::string> warnings_of(const Desk& desk) {
  const Outcome o = desk.run("airside", {"check", "site.toml", "--json"});
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  std::vector<std::string> texts;
  const json all = object_of(o);
  for (const json& w : all.at("warnings")) texts.push_back(w.value("text", ""));
  for (const std::string& text : texts) EXPECT_TRUE(has(o.err, text)) << o.err;
  return texts;
}

TEST(Check, WarnsOfWhatIsSeldomMeant) {
  const Desk desk;
  desk.site();
  EXPECT_TRUE(warnings_of(desk).empty());
  EXPECT_EQ(desk.run("airside", {"check", "site.toml", "--strict"}).code, 0);
  const auto warned = [&](const char* file, const char* from, const char* to, const std::string& words) {
    const std::string before = text_of_file(desk.path(file));
    desk.edit(file, from, to);
    const std::vector<std::string> texts = warnings_of(desk);
    ASSERT_EQ(texts.size(), 1u) << from;
    EXPECT_TRUE(has(texts[0], words)) << texts[0];
    EXPECT_EQ(desk.run("airside", {"check", "site.toml", "--strict"}).code, 1);
    desk.write(file, before);
  };
  warned("points.csv", "setpoint,degc,3,0,", "setpoint,degc,3,40001,", "40001 is usually register 0 of function 3");
  warned("points.csv", "rain,,4,", "rain,,4,300", "30001 is usually register 0 of function 4");
  warned("points.csv", "heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,refresh,6,,self\n", "", "no writable heartbeat");
  warned("points.csv", "vav_on_1,,4,10,uint16,big,big,1,", "vav_on_1,,4,10,uint16,big,big,0.01,", "scale 0.01");
  warned("site.toml", "work_degc = 20.5", "work_degc = 19", "expert.work_degc = 19 is below setpoint.min_degc = 20");
}

// ---- What a figure was made by

void expect_facts(const json& j, const char* plant) {
  EXPECT_EQ(j.value("plant_kind", ""), plant) << j.dump();
  for (const char* key : {"engine", "weather", "version", "commit"}) EXPECT_NE(j.value(key, ""), "") << key << j.dump();
}

TEST(RunFacts, NamePlantWeatherAndCommitAndSayThatAnotherPlantRuns) {
  const Desk desk;
  const std::string simulate = "simulate --method expert --expert-days 0 --days 1 ";
  const Outcome fallen = desk.shell(no_engine + ("exec $airside " + simulate + "--report rep --json"));
  ASSERT_EQ(fallen.code, 0) << fallen.err;
  EXPECT_TRUE(has(fallen.err, "note: the RC plant runs, since EnergyPlus is not installed")) << fallen.err;
  const json j = object_of(fallen);
  expect_facts(j, "rc");
  EXPECT_TRUE(has(j.value("fallback", ""), "not installed"));
  EXPECT_TRUE(has(j.value("plant", ""), "RC room 301"));
  const std::string version = desk.run("airside", {"--version"}).out;
  EXPECT_TRUE(has(version, "commit " + j.value("commit", "none"))) << version;
  const std::string page = text_of_file(desk.path("rep/index.html"));
  const std::string head = page.substr(0, page.find("<h1>"));
  EXPECT_TRUE(has(head, "RC room 301") && has(head, "synthetic") && has(head, "commit " + j.value("commit", "none")));
  const Outcome meant = desk.run("airside", Desk::split(simulate + "--plant rc"));
  EXPECT_FALSE(has(meant.err, "note:")) << meant.err;
  EXPECT_TRUE(has(meant.out, "RC plant of airside") && has(meant.out, "commit ")) << meant.out;
}

TEST(RunFacts, AreInEveryOutput) {
  const Desk desk;
  const std::string pretrain = "pretrain --plant rc --days 2 --updates 1 -o a.blob --log log.csv";
  expect_facts(object_of(desk.run("airside", Desk::split(pretrain + " --json"))), "rc");
  EXPECT_TRUE(has(desk.run("airside", Desk::split(pretrain)).out, "commit "));
  const std::string transfer = "transfer --from a.blob --log log.csv --steps 1 -o b.blob";
  EXPECT_NE(object_of(desk.run("airside", Desk::split(transfer + " --json"))).value("commit", ""), "");
  EXPECT_TRUE(has(desk.run("airside", Desk::split(transfer)).out, "commit "));
  const std::string study =
      "study rooms --plant rc --rooms 301 --seeds 1 --methods expert,floor-frozen --no-paper --pretrain-days 2 "
      "--expert-days 1 --days 1 --updates 1 --steps 1";
  expect_facts(object_of(desk.run("airside", Desk::split(study + " --json"))), "rc");
  EXPECT_TRUE(has(desk.run("airside", Desk::split(study)).out, "commit "));
  EXPECT_NE(object_of(desk.run("airside", {"report", "log.csv", "-o", "rep", "--json"})).value("commit", ""), "");
}

TEST(RunFacts, HaveCommandsThatCanBeCopiedWhereFoldersHaveABlank) {
  const Desk desk;
  fs::create_directory(desk.path("a b"));
  const auto run = [&desk](const std::vector<std::string>& words) {
    const Outcome o = desk.run("airside", words);
    EXPECT_EQ(o.code, 0) << o.err;
    return o.out;
  };
  run({"pretrain", "--plant", "rc", "--days", "2", "--updates", "1", "-o", "a b/a.blob", "--log", "a b/log.csv"});
  run({"transfer", "--from", "a b/a.blob", "--log", "a b/log.csv", "--steps", "1", "-o", "a b/b.blob"});
  const std::string said = object_of({0, run({"blob", "inspect", "a b/b.blob", "--json"}), ""}).value("provenance", "");
  EXPECT_TRUE(said.starts_with("airside transfer --from 'a b/a.blob' --log 'a b/log.csv' --steps 1 ")) << said;
  const std::string next =
      run({"gap", "blind", "--cases", "1", "--days", "4", "--rough", "-o", "a b/cases", "--key", "a b/key.json"});
  EXPECT_TRUE(has(next, "airside gap run-cases 'a b/cases' -o verdicts.json; airside gap score verdicts.json 'a b/key"))
      << next;
}

TEST(RunFacts, NameTheEngineAndTheFileOfWeather) {
  if (!sim::have_energyplus()) GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed; run tools/setup";
  const Desk desk;
  const json j = object_of(
      desk.run("airside", Desk::split("simulate --plant energyplus --method expert --expert-days 0 --days 1 --json")));
  expect_facts(j, "energyplus");
  EXPECT_TRUE(has(j.value("engine", ""), "EnergyPlus 25.2.0")) << j["engine"];
  EXPECT_TRUE(has(j.value("weather", ""), "Tampa") && has(j.value("weather", ""), "CRC-32C")) << j["weather"];
}

// ---- Weights that have no place

TEST(Pretrain, SeesAFullDiskBeforeItTrains) {
  const Desk desk;
  const Outcome o = desk.shell("ulimit -f 50; exec $airside pretrain --plant rc --days 300 -o x.blob");
  EXPECT_EQ(o.code, 1);
  EXPECT_FALSE(has(o.err, "started")) << o.err;
  EXPECT_TRUE(has(o.err, "x.blob: found no room for the weights: File too large; expected room for ")) << o.err;
  EXPECT_FALSE(has(o.err, "control goes on")) << o.err;
  EXPECT_TRUE(names_in(desk.folder()).empty());
}

TEST(Pretrain, KeepsWhatItTrainedWhereItsPlaceIsLost) {
  const Desk desk;
  const Outcome o = desk.shell(
      "mkdir d t; TMPDIR=$PWD/t $airside pretrain --plant rc --days 8 --updates 1 -o d/x.blob & n=0; "
      "while [ ! -e d/x.blob.part ] && [ $n -lt 400 ]; do sleep 0.02; n=$((n + 1)); done; rm -rf d; wait $!");
  EXPECT_EQ(o.code, 1) << o.err;
  const Said said = complaint_in(o.err);
  EXPECT_TRUE(has(said.remedy, "the weights are kept in ")) << o.err;
  const std::set<std::string> left = names_in(desk.path("t"));
  ASSERT_EQ(left.size(), 1u) << o.err;
  EXPECT_TRUE(has(said.remedy, *left.begin())) << said.remedy;
  EXPECT_EQ(desk.run("airside", {"check", "--weights", "t/" + *left.begin()}).code, 0);
}

// ---- Reports of logs

/// Cuts log.csv of two days into the files of a box.
void daily_files(const Desk& desk, const std::string& folder) {
  fs::create_directory(desk.path(folder));
  std::istringstream log(text_of_file(desk.path("log.csv")));
  std::string header, line;
  std::getline(log, header);
  std::map<std::string, std::string> files;
  while (std::getline(log, line)) {
    const std::string part = line.substr(0, 10) == "2021-07-02" && line.substr(11, 2) >= "12" ? "_01" : "";
    std::string& text = files[folder + "/airside-" + line.substr(0, 10) + part + ".csv"];
    if (text.empty()) text = header + "\n";
    text += line + "\n";
  }
  for (const auto& [name, text] : files) desk.write(name, text);
}

TEST(Report, TakesTheDailyFilesOfABoxForOneLog) {
  const Desk desk;
  desk.blob();
  daily_files(desk, "log");
  daily_files(desk, "other");
  const auto report = [&desk](const std::string& words) {
    return object_of(desk.shell("exec $airside report -o rep --json " + words))["methods"];
  };
  const json one = report("log/*.csv");
  ASSERT_EQ(one.size(), 1u) << one.dump();
  EXPECT_EQ(one["log"]["rows"], 480);
  EXPECT_EQ(one["log"]["missing_rows"], 0);
  EXPECT_EQ(one["log"]["files"].size(), 3u);
  const json folder = report("log");
  EXPECT_EQ(folder["log"]["dae_degc"], one["log"]["dae_degc"]);
  const json two = report("log/*.csv other/*.csv --name a --name b");
  ASSERT_EQ(two.size(), 2u) << two.dump();
  EXPECT_EQ(two["a"]["dae_degc"], two["b"]["dae_degc"]);
  const json apart = report("log/airside-2021-07-01.csv log/airside-2021-07-02.csv --name thu --name fri");
  ASSERT_EQ(apart.size(), 2u) << apart.dump();
  EXPECT_EQ(apart["thu"]["rows"], 240);
  const json joined =
      report("log/airside-2021-07-02.csv log/airside-2021-07-01.csv log.csv --name a --name a --name b");
  ASSERT_EQ(joined.size(), 2u) << joined.dump();
  EXPECT_EQ(joined["a"]["rows"], 360);
}

TEST(Report, SaysThatALogLooksLikeFahrenheit) {
  const Desk desk;
  desk.blob();
  std::istringstream log(text_of_file(desk.path("log.csv")));
  std::string header, line, all;
  std::getline(log, header);
  std::vector<bool> degc;
  std::istringstream names(header);
  for (std::string name; std::getline(names, name, ',');) degc.push_back(name.ends_with("_degc"));
  all = header + "\n";
  while (std::getline(log, line)) {
    std::istringstream fields(line);
    std::size_t i = 0;
    std::string row;
    for (std::string field; std::getline(fields, field, ','); ++i) {
      const bool convert = degc[i] && !field.empty();
      row += (i == 0 ? "" : ",") + (convert ? std::to_string(std::stod(field) * 1.8 + 32) : field);
    }
    all += row + std::string(degc.size() - i, ',') + "\n";
  }
  desk.write("log.csv", all);
  const Outcome o = desk.run("airside", {"report", "log.csv", "-o", "rep"});
  EXPECT_EQ(o.code, 1);
  const Said said = complaint_in(o.err);
  EXPECT_TRUE(has(said.place, "log.csv: room_temp_1_degc")) << o.err;
  EXPECT_TRUE(has(said.found, "look like degF")) << o.err;
  EXPECT_TRUE(has(said.remedy, "convert")) << o.err;
}

// ---- Sources for a new room

TEST(BlobRank, OrdersWhatFitsAndSaysWhyTheRestDoesNot) {
  const Desk desk;
  desk.make("simulate --plant rc --room 301 --method expert --expert-days 0 --days 2 --log log.csv");
  desk.make("transfer --log log.csv --steps 1 -o one.blob");
  desk.make("simulate --plant rc --topology 3vav-0fcu-1power --method expert --expert-days 0 --days 2 --log other.csv");
  desk.make("transfer --topology 3vav-0fcu-1power --log other.csv --steps 1 -o other.blob");
  const Outcome o = desk.run("airside", Desk::split("blob rank other.blob one.blob --log log.csv --json"));
  EXPECT_EQ(o.code, 0) << o.err;
  const json found = object_of(o);
  ASSERT_EQ(found["sources"].size(), 2U) << o.out;
  EXPECT_EQ(found["sources"][0]["blob"], "one.blob");
  EXPECT_GT(found["sources"][0]["forecast_error_k"].get<double>(), 0);
  EXPECT_TRUE(has(found["sources"][1].value("refused", ""), "other.blob")) << o.out;
  const Outcome nothing = desk.run("airside", Desk::split("blob rank other.blob --log log.csv"));
  EXPECT_EQ(nothing.code, 1);
  EXPECT_TRUE(has(nothing.err, "no blob that fits this site")) << nothing.err;
  desk.write("none.blob", "not weights");
  const Outcome broken = desk.run("airside", Desk::split("blob rank one.blob none.blob --log log.csv"));
  EXPECT_EQ(broken.code, 1) << "a file that cannot be read is a mistake, not another room";
  EXPECT_TRUE(has(broken.err, "none.blob")) << broken.err;
}

// ---- The gap workflow on simulated logs

TEST(Gap, FindsTheMadeUpWeatherBesideALogOfTheRcPlant) {
  const Desk desk;
  desk.site();
  const std::string simulate = "simulate --plant rc --room 301 --method expert --expert-days 0 --days 4 ";
  desk.make(simulate + "--start 2021-07-01 --log ref.csv");
  desk.make(simulate + "--start 2021-07-08 --log log.csv");
  EXPECT_EQ(text_of_file(desk.path("ref.epw")), text_of_file(desk.path("log.epw")));
  const std::string gap =
      "gap --site site.toml --measured log.csv --reference ref.csv --plant rc --room 301 --out gap-report/ --json";
  const Outcome o = run_program("airside", Desk::split(gap), desk.folder(), desk.folder(), 900);
  EXPECT_EQ(o.code, 0) << o.err;
  const json found = object_of(o);
  EXPECT_NE(found.value("verdict", ""), "") << o.out;
  expect_facts(found, "rc");
  const std::string page = text_of_file(desk.path("gap-report/index.html"));
  const std::string head = page.substr(0, page.find("<h1>"));
  EXPECT_TRUE(has(head, "weather log.epw") && has(head, "commit " + found.value("commit", "none"))) << head;
  desk.write("log.epw", "other");
  const Outcome other = desk.run("airside", Desk::split(gap));
  EXPECT_EQ(other.code, 1);
  EXPECT_TRUE(has(other.err, "ref.epw: found other weather than in log.epw")) << other.err;
}

}  // namespace
}  // namespace airside
