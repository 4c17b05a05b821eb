// airside residual: a network learns what the room head gets wrong, the blob carries it, and the gate stops asking one
// that does not suit the room.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "airside/splitmix64.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"
#include "support/program.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/training/built_in_residual.hpp"
#include "tools/run/training/residual_cycles.hpp"
#include "tools/run/training/residual_training.hpp"
#include "tools/run/training/transfer.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {
namespace {

using nlohmann::json;

/// Errors that a part of them follows the deviation; the rest is noise.
std::vector<ResidualSample> drawn_samples(std::size_t count, double share, std::uint64_t seed) {
  SplitMix64 draw(seed);
  std::vector<ResidualSample> out(count);
  for (ResidualSample& s : out) {
    for (float& x : s.x) x = static_cast<float>(draw.symmetric());
    const auto x = static_cast<double>(s.x[ResidualFeatures::deviation]);
    s.error_k = static_cast<float>(share * 0.1 * std::abs(x) + (1 - share) * 0.1 * draw.symmetric());
  }
  return out;
}

TEST(ResidualTraining, FindsWhatIsThereAndNothingInNoise) {
  const ResidualNetwork found = train_residual(drawn_samples(20000, 1, 1), {});
  const ResidualScore score = score_of(found, drawn_samples(4000, 1, 2));
  EXPECT_EQ(score.samples, 4000u);
  EXPECT_GT(score.r2, 0.95);
  EXPECT_LT(score.ratio, 0.2);
  const ResidualNetwork none = train_residual(drawn_samples(20000, 0, 3), {});
  const ResidualScore noise = score_of(none, drawn_samples(4000, 0, 4));
  EXPECT_NEAR(noise.ratio, 1, 0.03);
  EXPECT_LT(noise.r2, 0.01);
}

TEST(ResidualTraining, GivesTheSameNetworkForTheSameSeed) {
  const auto samples = drawn_samples(2000, 0.5, 1);
  EXPECT_EQ(train_residual(samples, {}).values, train_residual(samples, {}).values);
  EXPECT_NE(train_residual(samples, {}).values, train_residual(samples, {.seed = 2}).values);
}

TEST(ResidualTraining, AsksForMoreThanAHandful) {
  try {
    (void)train_residual(drawn_samples(100, 1, 1), {});
    FAIL();
  } catch (const hal::InputError& e) {
    EXPECT_EQ(e.found(), "100");
    EXPECT_NE(e.remedy().find("more days"), std::string::npos);
  }
}

Trial trial_in(const std::string& room, int days) {
  PlantChoice plant;
  plant.kind = "rc";
  plant.room = room;
  plant.start = "2021-08-01";
  return {built_in_site(), plant, 5, days};
}

Metrics controlled(const Trial& trial, const BlobBytes& blob) {
  Prepared prepared = prepare(trial);
  return metrics_of(trial.site, run_ours(trial, prepared, {blob, false, 0}));
}

/// A network that always says 0.3 K.
ResidualNetwork wrong_network() {
  ResidualNetwork wrong;
  std::vector<float> values(ResidualNetwork::parameters, 0.0f);
  for (int i = 0; i < ResidualNetwork::inputs; ++i) values[static_cast<std::size_t>(ResidualNetwork::inputs + i)] = 1;
  values.back() = 0.3f;
  wrong.take(values);
  return wrong;
}

BlobBytes plain_blob(const Trial& trial) {
  Prepared prepared = prepare(trial);
  FineTuneOptions options;
  options.steps = 300;
  return transfer(trial.site, {}, prepared.history, options).blob;
}

TEST(ResidualForecast, TheLogSaysWhatWasExpectedAndHowMuchOfTheNetworkCounts) {
  const Trial trial = trial_in("301-real", 4);
  Prepared prepared = prepare(trial);
  const ControlRun run =
      run_ours(trial, prepared, {with_residual(trial.site, plain_blob(trial), wrong_network(), ""), false, 0});
  const auto mean = [](const hal::LogRow& row) {
    return (row.value[0] + row.value[1] + row.value[2] + row.value[3] + row.value[4]) / 5;
  };
  double wrong_k2 = 0, said_k2 = 0;
  int counted = 0;
  std::vector<double> shares;
  for (std::size_t i = 3; i + 3 < run.rows.size(); ++i) {
    const hal::ControllerColumns& c = run.rows[i].controller;
    if (!std::isfinite(c.expected_held_degc)) continue;
    if (std::isfinite(c.residual_share)) {
      EXPECT_EQ(c.residual_forecast_k, static_cast<double>(0.3f));
      shares.push_back(c.residual_share);
      if (c.residual_share > 0) continue;  // what is wrong on purpose is no measure of the error
    }
    wrong_k2 += std::pow(mean(run.rows[i + 3]) - c.expected_held_degc, 2);
    said_k2 += c.expected_error_k * c.expected_error_k;
    ++counted;
  }
  ASSERT_GT(shares.size(), 80u);
  EXPECT_EQ(shares.front(), 1);
  EXPECT_EQ(shares.back(), 0);
  ASSERT_GT(counted, 200);
  EXPECT_GT(said_k2 / wrong_k2, 0.7);
  EXPECT_LT(said_k2 / wrong_k2, 1.5);
}

TEST(ResidualForecast, ANetworkThatIsWrongIsNotAskedForLong) {
  const Trial trial = trial_in("301-real", 10);
  const BlobBytes plain = plain_blob(trial);
  const ResidualNetwork wrong = wrong_network();
  const Metrics alone = controlled(trial, plain),
                misled = controlled(trial, with_residual(trial.site, plain, wrong, ""));
  EXPECT_GT(misled.days.front().dae_degc, alone.days.front().dae_degc + 0.005) << "it is asked at first";
  for (std::size_t day = 2; day < alone.days.size(); ++day) {
    EXPECT_LT(misled.days[day].dae_degc, alone.days[day].dae_degc + 0.01) << "day " << day + 1;
  }
}

class ResidualCommand : public ::testing::Test {
 protected:
  Outcome run(std::vector<std::string> words) const {
    return run_program("airside", std::move(words), folder.path(), scratch.path(), 300);
  }
  TemporaryFolder folder, scratch;
};

TEST_F(ResidualCommand, AddsANetworkThatHelpsInARoomThatItHasNotSeen) {
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "5", "--no-residual", "-o", "plain.blob"}).code, 0);
  const Outcome taught =
      run({"residual", "plain.blob", "--plant", "rc", "--rooms", "tuning-0,tuning-1,tuning-2", "--try-rooms",
           "tuning-3", "--scenarios", "outages", "--seeds", "1", "-o", "taught.blob", "--json"});
  ASSERT_EQ(taught.code, 0) << taught.err;
  const json found = json::parse(taught.out);
  ASSERT_TRUE(found["written"]) << taught.out;
  EXPECT_LT(found["error_ratio"], 0.99);
  EXPECT_EQ(found["tried_cycles"], 28 * 40);
  EXPECT_EQ(fs::file_size(folder.path() / "taught.blob"),
            fs::file_size(folder.path() / "plain.blob") + sizeof(float) * ResidualNetwork::parameters);
  const auto dae = [&](const std::string& blob) {
    const Outcome o = run({"simulate", "--plant", "rc", "--room", "tuning-5", "--scenario", "outages", "--weights",
                           blob, "--transfer", "--json"});
    EXPECT_EQ(o.code, 0) << o.err;
    return json::parse(o.out)["dae_degc"].get<double>();
  };
  EXPECT_LT(dae("taught.blob"), 0.99 * dae("plain.blob"));
  const Outcome inspected = run({"blob", "inspect", "taught.blob"});
  EXPECT_EQ(inspected.code, 0);
  EXPECT_NE(inspected.out.find("airside residual"), std::string::npos) << inspected.out;
}

TEST_F(ResidualCommand, LearnsFromCyclesThatWereKept) {
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "3", "--no-residual", "-o", "plain.blob"}).code, 0);
  const auto keep = [&](const std::string& room, const std::string& file) {
    return run({"residual", "plain.blob", "--plant", "rc", "--rooms", room, "--try-rooms", "tuning-9", "--scenarios",
                "outages", "--seeds", "1", "--days", "14", "--keep", file, "-o", "once.blob"});
  };
  ASSERT_EQ(keep("tuning-0", "a.cycles").code, 0);
  ASSERT_EQ(keep("tuning-1", "b.cycles").code, 0);
  EXPECT_EQ(fs::file_size(folder.path() / "a.cycles"), 32u + 2 * 14 * 40 * 19 * sizeof(float));
  const Outcome both = run({"residual", "plain.blob", "--cycles", "a.cycles,b.cycles", "--text", "numbers.inc", "-o",
                            "both.blob", "--json"});
  ASSERT_EQ(both.code, 0) << both.err;
  const json found = json::parse(both.out);
  EXPECT_EQ(found["learned_cycles"], 2 * 14 * 40);
  ASSERT_EQ(found["tried"].size(), 3u) << "each file, and all";
  EXPECT_EQ(found["tried"][0]["what"], "a.cycles");
  EXPECT_EQ(found["tried"][2]["error_ratio"], found["error_ratio"]);
  EXPECT_EQ(found["written"], found["error_ratio"] <= 0.99);
  EXPECT_EQ(fs::exists(folder.path() / "numbers.inc"), found["written"]);
  EXPECT_EQ(fs::exists(folder.path() / "both.blob"), found["written"]);
}

TEST_F(ResidualCommand, TextHoldsAllBitsOfTheBuiltInNetwork) {
  const fs::path text = folder.path() / "numbers.inc";
  write_residual_text(text.string(), built_in_residual());
  EXPECT_EQ(text_of_file(text),
            text_of_file(fs::path(AIRSIDE_SOURCE_DIR) / "tools/run/training/built_in_residual.inc"));
  std::ifstream in(text);
  std::string number;
  std::size_t i = 0;
  for (; in >> number; ++i) EXPECT_EQ(std::stof(number), built_in_residual().values.at(i)) << i;
  EXPECT_EQ(i, std::size_t{ResidualNetwork::parameters});
  EXPECT_THROW(write_residual_text((folder.path() / "none" / "numbers.inc").string(), built_in_residual()),
               hal::InputError);
}

TEST_F(ResidualCommand, RefusesAFileThatHoldsNoCycles) {
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "3", "--no-residual", "-o", "plain.blob"}).code, 0);
  const auto complaint = [&](const std::string& bytes) {
    std::ofstream(folder.path() / "bad.cycles", std::ios::binary) << bytes;
    const Outcome o = run({"residual", "plain.blob", "--cycles", "bad.cycles", "-o", "none.blob"});
    EXPECT_EQ(o.code, 1);
    EXPECT_FALSE(fs::exists(folder.path() / "none.blob"));
    return o.err;
  };
  const auto header = [](std::uint32_t regressors, std::uint32_t learned, std::uint32_t cycle_min = 18) {
    const std::array<std::uint32_t, 4> numbers{regressors, cycle_min, learned, 0};
    return "airside cycles 1" + std::string(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
  };
  EXPECT_NE(complaint("few").find("3 bytes"), std::string::npos);
  EXPECT_NE(complaint(std::string(80, 'x')).find("another kind of file"), std::string::npos);
  EXPECT_NE(complaint(header(17, 0)).find("17 regressors"), std::string::npos);
  EXPECT_NE(complaint(header(18, 0, 12)).find("cycles of 12 min"), std::string::npos);
  EXPECT_NE(complaint(header(18, 1)).find("of 1 cycles"), std::string::npos);
  EXPECT_NE(complaint(header(18, 1) + std::string(76, '\xFF')).find("not finite"), std::string::npos);
  EXPECT_NE(run({"residual", "plain.blob", "--cycles", "absent.cycles"}).err.find("absent.cycles"), std::string::npos);
  EXPECT_NE(run({"residual", "plain.blob", "--cycles", "a", "--rooms", "tuning-0"}).code, 0);
}

TEST_F(ResidualCommand, PretrainedWeightsCarryTheBuiltInNetwork) {
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "3", "-o", "with.blob"}).code, 0);
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "3", "--no-residual", "-o", "without.blob"}).code, 0);
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "3", "--preset", "paper", "-o", "paper.blob"}).code, 0);
  const auto header = [&](const std::string& blob, const char* field) {
    const Outcome o = run({"blob", "inspect", blob, "--json"});
    EXPECT_EQ(o.code, 0) << o.err;
    return json::parse(o.out)["header"][field].get<std::string>();
  };
  EXPECT_EQ(header("with.blob", "residual_parameters"), "1189");
  EXPECT_EQ(header("without.blob", "residual_parameters"), "0");
  EXPECT_EQ(header("paper.blob", "residual_parameters"), "0") << "there is no head whose error it could predict";
  EXPECT_EQ(header("with.blob", "head_states"), "94") << "days off do not travel unless somebody asks for them";
  EXPECT_TRUE(built_in_residual().is_sound());
  const auto dae = [&](const std::string& blob) {
    const Outcome o = run({"simulate", "--plant", "rc", "--room", "tuning-11", "--scenario", "outages", "--weights",
                           blob, "--transfer", "--json"});
    EXPECT_EQ(o.code, 0) << o.err;
    return json::parse(o.out)["dae_degc"].get<double>();
  };
  EXPECT_LT(dae("with.blob"), 0.97 * dae("without.blob"));
}

TEST_F(ResidualCommand, LeavesTheBlobWhereNothingWasLearned) {
  ASSERT_EQ(run({"pretrain", "--plant", "rc", "--days", "3", "--no-residual", "-o", "plain.blob"}).code, 0);
  const auto before = fs::file_size(folder.path() / "plain.blob");
  const Outcome few = run({"residual", "plain.blob", "--plant", "rc", "--rooms", "tuning-0", "--try-rooms", "tuning-1",
                           "--scenarios", "summer", "--seeds", "1", "--days", "2"});
  EXPECT_EQ(few.code, 1);
  EXPECT_NE(few.err.find("at least 512"), std::string::npos) << few.err;
  EXPECT_EQ(fs::file_size(folder.path() / "plain.blob"), before);
  EXPECT_EQ(run({"residual", "plain.blob", "--plant", "rc", "--scenarios", "monsoon"}).code, 1);
  EXPECT_EQ(run({"residual", "plain.blob", "--plant", "rc", "--rooms", "nowhere"}).code, 1);
  EXPECT_EQ(run({"residual", "absent.blob", "--plant", "rc"}).code, 1);
  EXPECT_EQ(fs::file_size(folder.path() / "plain.blob"), before);
}

}  // namespace
}  // namespace airside::tools
