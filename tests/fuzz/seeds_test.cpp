// Every seed of every fuzz target, and seeded mutants of them, as plain tests: what the campaign found stays found.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "airside/splitmix64.hpp"
#include "fuzz/target.hpp"

namespace airside::fuzz {
namespace {

/// Uniform in [0, n).
std::size_t below(SplitMix64& draw, std::size_t n) { return draw.below(static_cast<std::uint32_t>(n)); }

class Fuzz : public ::testing::TestWithParam<const Target*> {};

/// One to four edits of the kind that libFuzzer makes.
Bytes mutant(const std::vector<Bytes>& seeds, const std::vector<std::string>& words, std::size_t max_bytes,
             SplitMix64& draw) {
  Bytes input = seeds[below(draw, seeds.size())];
  const std::size_t edits = 1 + below(draw, 4);
  for (std::size_t e = 0; e < edits; ++e) {
    const auto at = static_cast<std::ptrdiff_t>(below(draw, input.size() + 1));
    const auto length = static_cast<std::ptrdiff_t>(
        std::min<std::size_t>(1 + below(draw, 16), input.size() - static_cast<std::size_t>(at)));
    const std::size_t kind = below(draw, words.empty() ? 5 : 6);
    if (kind == 0 && length > 0) {
      input[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1U << below(draw, 8));
    } else if (kind == 1 && length > 0) {
      static constexpr std::uint8_t marks[] = {0, 0xFF, 0x7F, 0x80, '\n', ',', '"', '0', '-', ' '};
      input[static_cast<std::size_t>(at)] = marks[below(draw, std::size(marks))];
    } else if (kind == 2) {
      input.erase(input.begin() + at, input.begin() + at + length);
    } else if (kind == 3) {
      const Bytes piece(input.begin() + at, input.begin() + at + length);
      input.insert(input.begin() + static_cast<std::ptrdiff_t>(below(draw, input.size() + 1)), piece.begin(),
                   piece.end());
    } else if (kind == 4) {
      const Bytes& other = seeds[below(draw, seeds.size())];
      const auto from = static_cast<std::ptrdiff_t>(below(draw, other.size() + 1));
      input.resize(static_cast<std::size_t>(at));
      input.insert(input.end(), other.begin() + from, other.end());
    } else if (!words.empty()) {
      const std::string& word = words[below(draw, words.size())];
      input.insert(input.begin() + at, word.begin(), word.end());
    }
  }
  if (input.size() > max_bytes) input.resize(max_bytes);
  return input;
}

TEST_P(Fuzz, SeedsAndTheirMutantsKeepTheClaims) {
  const Target& target = *GetParam();
  const std::vector<Bytes> seeds = target.seeds();
  EXPECT_TRUE(target.run(seeds.front())) << "the first seed is sound, so that the claims are about something";
  for (const Bytes& seed : seeds) {
    EXPECT_LE(seed.size(), target.max_bytes);
    target.run(seed);
  }
  const char* wish = std::getenv("AIRSIDE_FUZZ_MUTANTS");
  const std::uint64_t mutants = wish != nullptr ? std::strtoull(wish, nullptr, 10) : 1500;
  const std::vector<std::string> words = target.words != nullptr ? target.words() : std::vector<std::string>{};
  SplitMix64 draw(5);
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 0; i < mutants; ++i) {
    Bytes input = mutant(seeds, words, target.max_bytes, draw);
    if (target.repair != nullptr && i % 4 != 0) target.repair(input, static_cast<std::uint32_t>(draw.next()));
    if (target.run(input)) ++accepted;
  }
  EXPECT_GT(accepted, 0u) << "no mutant was taken: the mutations reach nothing";
  EXPECT_LT(accepted, mutants) << "no mutant was refused";
}

INSTANTIATE_TEST_SUITE_P(Target, Fuzz, ::testing::ValuesIn(all_targets()),
                         [](const auto& chosen) { return std::string(chosen.param->name); });

/// Inputs that once broke a claim: found/TARGET-WHAT.
TEST(FuzzFindings, KeepTheClaimsNow) {
  const std::filesystem::path folder = AIRSIDE_SOURCE_DIR "/tests/fuzz/found";
  std::size_t tried = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    for (const Target* target : all_targets()) {
      if (!name.starts_with(std::string(target->name) + "-")) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(in), {}};
      target->run(bytes_of(text));
      ++tried;
    }
  }
  EXPECT_GT(tried, 0u);
}

}  // namespace
}  // namespace airside::fuzz
