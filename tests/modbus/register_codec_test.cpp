// Every type in every byte and word order comes back as it went, and nonsense never becomes a number.

#include "hal/points/register_codec.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "airside/splitmix64.hpp"

namespace airside::hal {
namespace {

constexpr std::array register_types = {PointType::int16, PointType::uint16, PointType::int32, PointType::uint32,
                                       PointType::float32};

Point make_point(PointType type, Endian bytes = Endian::big, Endian words = Endian::big) {
  Point p;
  p.type = type;
  p.byte_order = bytes;
  p.word_order = words;
  p.min = -1e300;
  p.max = 1e300;
  return p;
}

std::vector<double> samples(PointType type) {
  switch (type) {
    case PointType::int16: return {0, 1, -1, 258, -32767, -32768, 32767};
    case PointType::uint16: return {0, 1, 258, 65534, 65535};
    case PointType::int32: return {0, -1, 0x01020304, -2147483648.0, 2147483647.0};
    case PointType::uint32: return {0, 1, 0x01020304, 4294967295.0};
    case PointType::float32: return {0, 1.5, -25.25, 0x1p-100, -0x1p127, 0x1.99999ap-4};
    default: return {0, 1};
  }
}

TEST(RegisterCodec, RoundTripsEveryTypeInEveryOrder) {
  for (const PointType type : register_types) {
    for (const Endian bytes : {Endian::big, Endian::little}) {
      for (const Endian words : {Endian::big, Endian::little}) {
        const Point p = make_point(type, bytes, words);
        for (const double value : samples(type)) {
          const auto registers = encode(p, value);
          ASSERT_TRUE(registers) << value;
          EXPECT_EQ(registers->count, p.width());
          const auto back = decode(p, registers->used());
          ASSERT_TRUE(back) << value;
          EXPECT_NEAR(*back, value, std::abs(value) < 1e3 ? 5e-7 : 0) << "to the millionth";
          EXPECT_EQ(encode(p, *back)->word, registers->word) << value;
        }
      }
    }
  }
}

TEST(RegisterCodec, ValuesAreWhatAPersonWouldWrite) {
  Point tenths = make_point(PointType::int16);
  tenths.scale = 0.1;
  EXPECT_EQ(rounded(tenths, 22.4), 22.4) << "224 * 0.1 is 22.400000000000002";
  Point degf = tenths;
  degf.scale = 1 / 18.0;
  degf.offset = -160 / 9.0;
  EXPECT_EQ(rounded(degf, 22.39), 22.388889);
  EXPECT_EQ(rounded(make_point(PointType::float32), 2.22), 2.22) << "not the float's 2.2200000286102295";
  EXPECT_EQ(rounded(make_point(PointType::float32), 0x1p-40), 0x1p-40) << "what no signal is stays";
}

TEST(RegisterCodec, OrdersAreWhatTheFieldCallsAbcdCdabBadcDcba) {
  using Words = std::array<std::uint16_t, 2>;
  const double value = 0x0A0B0C0D;
  const auto words = [&](Endian bytes, Endian order) {
    return encode(make_point(PointType::uint32, bytes, order), value)->word;
  };
  EXPECT_EQ(words(Endian::big, Endian::big), (Words{0x0A0B, 0x0C0D}));
  EXPECT_EQ(words(Endian::big, Endian::little), (Words{0x0C0D, 0x0A0B}));
  EXPECT_EQ(words(Endian::little, Endian::big), (Words{0x0B0A, 0x0D0C}));
  EXPECT_EQ(words(Endian::little, Endian::little), (Words{0x0D0C, 0x0B0A}));
}

TEST(RegisterCodec, RoundingIsStableAndWithinHalfAStep) {
  SplitMix64 random{20240901};
  Point p = make_point(PointType::int16);
  p.scale = 0.01;
  p.min = -50;
  p.max = 60;
  for (int i = 0; i < 100000; ++i) {
    const double value = -49.0 + 108.0 * random.uniform();
    const double once = rounded(p, value);
    ASSERT_NEAR(once, value, 0.00501);
    ASSERT_EQ(rounded(p, once), once) << "a rounded value must be a fixed point";
  }
}

TEST(RegisterCodec, EveryRawWordIsAFixedPointOfRounding) {
  for (const double scale : {1.0, 0.1, 0.01, -0.1, 0.5556}) {
    Point p = make_point(PointType::int16);
    p.scale = scale;
    p.offset = -17.78;
    for (int raw = -32768; raw <= 32767; ++raw) {
      const std::uint16_t word = static_cast<std::uint16_t>(raw);
      const auto value = decode(p, {&word, 1});
      ASSERT_TRUE(value);
      ASSERT_EQ(encode(p, *value)->word[0], word);
    }
  }
}

TEST(RegisterCodec, NonsenseNeverBecomesANumber) {
  Point p = make_point(PointType::int16);
  p.scale = 0.01;
  p.min = 5;
  p.max = 45;
  p.sentinel = {0x8000, 0xFFFF};
  p.sentinels = 2;
  const auto fault = [&](std::uint16_t word) { return decode(p, {&word, 1}).error(); };
  EXPECT_EQ(fault(0x8000), Fault::not_finite);
  EXPECT_EQ(fault(0xFFFF), Fault::not_finite);
  EXPECT_EQ(fault(4501), Fault::out_of_range);
  EXPECT_EQ(fault(499), Fault::out_of_range);
  EXPECT_EQ(rounded(p, 45.0), 45.0);
  EXPECT_EQ(rounded(p, 5.0), 5.0);
  EXPECT_EQ(decode(p, {}).error(), Fault::out_of_range);
  EXPECT_EQ(encode(p, std::numeric_limits<double>::quiet_NaN()).error(), Fault::not_finite);
  EXPECT_EQ(encode(p, std::numeric_limits<double>::infinity()).error(), Fault::not_finite);
  EXPECT_EQ(encode(p, 1e9).error(), Fault::out_of_range);
  EXPECT_EQ(encode(p, -0.01).error(), Fault::out_of_range) << "it would read back as the sentinel 0xFFFF";
  EXPECT_TRUE(std::isnan(rounded(p, 50.0)));
  EXPECT_TRUE(std::isnan(rounded(p, std::numeric_limits<double>::quiet_NaN())));
}

TEST(RegisterCodec, FloatNanAndInfinityAreRefused) {
  const Point p = make_point(PointType::float32);
  for (const std::uint32_t bits : {0x7FC00000U, 0xFFC00001U, 0x7F800000U, 0xFF800000U}) {
    const std::array words = {static_cast<std::uint16_t>(bits >> 16), static_cast<std::uint16_t>(bits & 0xFFFFU)};
    EXPECT_EQ(decode(p, words).error(), Fault::not_finite);
  }
  EXPECT_EQ(encode(p, 1e39).error(), Fault::out_of_range);
}

TEST(RegisterCodec, InvalidRegistersDecodeAsInvalid) {
  for (const PointType type : register_types) {
    for (const Endian order : {Endian::big, Endian::little}) {
      Point p = make_point(type, order, order);
      p.min = -100;
      p.max = 100;
      EXPECT_FALSE(decode(p, invalid_registers(p).used()));
      p.sentinel[0] = 42;
      p.sentinels = 1;
      EXPECT_FALSE(decode(p, invalid_registers(p).used()));
    }
  }
}

TEST(RegisterCodec, ABitIsZeroOrOneAndNothingElse) {
  for (const PointType type : {PointType::coil, PointType::discrete}) {
    Point p = make_point(type, Endian::little, Endian::little);
    EXPECT_EQ(encode(p, 1.0)->word[0], 1) << "a bit has no byte order";
    EXPECT_EQ(encode(p, 0.2)->word[0], 0);
    EXPECT_EQ(encode(p, 2.0).error(), Fault::out_of_range);
    EXPECT_EQ(encode(p, -1.0).error(), Fault::out_of_range);
    const std::array<std::uint16_t, 2> words = {1, 0};
    EXPECT_EQ(decode(p, std::span(words).first(1)), 1.0);
    EXPECT_EQ(decode(p, std::span(words).last(1)), 0.0);
    EXPECT_EQ(invalid_registers(p).word[0], 0);
  }
}

TEST(RegisterCodec, NumbersThatTheTypeCannotHoldAreRefusedAtBothEnds) {
  const auto refused = [](PointType type, double value) {
    EXPECT_EQ(encode(make_point(type), value).error(), Fault::out_of_range) << static_cast<int>(type) << " " << value;
  };
  refused(PointType::int16, -32769);
  refused(PointType::int16, 32768);
  refused(PointType::uint16, -1);
  refused(PointType::uint16, 65536);
  refused(PointType::int32, -2147483649.0);
  refused(PointType::int32, 2147483648.0);
  refused(PointType::uint32, -1);
  refused(PointType::uint32, 4294967296.0);
  Point tiny = make_point(PointType::float32);
  tiny.scale = 1e-300;
  EXPECT_EQ(encode(tiny, 1e20).error(), Fault::out_of_range) << "raw is no number any more";
}

TEST(RegisterCodec, ATypeOutsideTheTableHoldsNothing) {
  const Point p = make_point(static_cast<PointType>(77));
  EXPECT_EQ(encode(p, 1).error(), Fault::out_of_range);
  const std::array<std::uint16_t, 2> words = {1, 2};
  EXPECT_EQ(decode(p, words).error(), Fault::not_finite);
  EXPECT_EQ(invalid_registers(p).word[0], 0);
}

}  // namespace
}  // namespace airside::hal
