// Sensors: nothing but fresh numbers within their limits, or the last good ones, passes the validator; nothing but a
// setpoint within limits and one rate step leaves the envelope.

#include <bit>
#include <cmath>

#include "airside/presets.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/validation.hpp"
#include "fuzz/target.hpp"

namespace airside::fuzz {
namespace {

using T = ThreeVav;
constexpr int n = Layout<T>::signals;

/// A number of the kind that sensors and broken ones give.
double number(Cursor& in) {
  const unsigned code = in.byte();
  switch (code) {
    case 255: return std::numeric_limits<double>::quiet_NaN();
    case 254: return std::numeric_limits<double>::infinity();
    case 253: return -std::numeric_limits<double>::infinity();
    case 252: return static_cast<double>(std::bit_cast<float>(in.word() << 16 | in.word()));
    case 251: return 65535;
    default: return static_cast<double>(code) * 0.25 - 10;
  }
}

bool validate(View input) {
  Cursor in(input);
  LimitsTable<T> limits = default_limits<T>();
  limits[0].stuck_s = 3600;
  const ControllerSettings settings = product_settings();
  Validator<T> validator(limits, settings);
  Reading<T> reading;
  reading.time = {1'000'000'800};
  reading.value.setConstant(0.5);
  reading.value.head<Layout<T>::rooms>().setConstant(24);
  bool any = false;
  double last = std::numeric_limits<double>::quiet_NaN();
  const SafetyEnvelope envelope(settings);
  while (!in.rest().empty()) {
    const unsigned step = in.byte();
    reading.time.seconds += step == 255 ? -7200 : step == 254 ? 1'000'000 : static_cast<std::int64_t>(step % 4) * row_s;
    const unsigned changes = in.byte() % 5;
    for (unsigned i = 0; i < changes; ++i) {
      const int signal = static_cast<int>(in.byte() % static_cast<unsigned>(n));
      reading.value(signal) = number(in);
      reading.age_s(signal) = (in.byte() & 7U) == 7U ? number(in) * 100 : 0;
    }
    const auto valid = validator.check(reading);
    if (valid) {
      any = true;
      int held = 0;
      for (int i = 0; i < n; ++i) {
        const double v = valid->value()(i);
        FUZZ_CLAIM(std::isfinite(v) && v >= limits[static_cast<std::size_t>(i)].min);
        FUZZ_CLAIM(v <= limits[static_cast<std::size_t>(i)].max);
        if (validator.faults()[static_cast<std::size_t>(i)] != Fault::none) ++held;
      }
      FUZZ_CLAIM(held == valid->held() && valid->learnable() == (held == 0));
    } else {
      FUZZ_CLAIM(valid.error() != Fault::none);
    }
    const double command = envelope.limit(number(in), last, number(in)).setpoint_degc();
    FUZZ_CLAIM(std::isfinite(command));
    FUZZ_CLAIM(command >= settings.limit_min_degc || last < command);
    FUZZ_CLAIM(command <= settings.limit_max_degc || last > command);
    if (std::abs(last) < 1e6) FUZZ_CLAIM(std::abs(command - last) <= settings.limit_change_k + 1e-9);
    last = (step & 16U) != 0 ? number(in) : command;
  }
  return any;
}

std::vector<Bytes> seeds() {
  Bytes calm;
  for (int row = 0; row < 12; ++row) {
    for (const int byte : {1, 2, 0, 136 + row % 3, 0, 1, 137 + row % 2, 0, 130, 130})
      calm.push_back(static_cast<std::uint8_t>(byte));
  }
  Bytes broken = calm;
  broken.insert(broken.end(), {1, 3, 0, 255, 0, 1, 251, 0, 2, 254, 7, 200, 255, 254, 255, 1, 0, 160, 0, 255, 255});
  return {calm, broken};
}

}  // namespace

const Target readings{"readings", 400, validate, nullptr, seeds, nullptr};

}  // namespace airside::fuzz
