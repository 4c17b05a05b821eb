#include "firmware/edge/report/plant_clock_report.hpp"

#include <algorithm>
#include <array>

#include "firmware/edge/report/say.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::edge {

void PlantClockReport::row(const hal::ModbusPlantClock::Jumps& jumps) {
  rows_left_ = std::max(rows_left_ - 1, 0);
  if (rows_left_ == 0) text_ = "ok";
  const bool taken = jumps.taken != said_.taken, doubted = jumps.doubted != said_.doubted;
  if (!taken && !doubted) return;
  said_ = jumps;
  const bool is_known = !taken && rows_left_ > 0;
  rows_left_ = rows_per_day;
  if (is_known) return;
  text_ = taken ? "jumped" : "read wrong";
  std::array<char, hal::civil_text_size> from{}, to{};
  hal::write_civil_text(from.data(), jumps.from);
  hal::write_civil_text(to.data(), jumps.to);
  say("the plant's clock {} {} after {}; {}", taken ? "went to" : "read", std::string_view(to.data(), to.size()),
      std::string_view(from.data(), from.size()),
      taken ? "it stays there, so control goes on from there" : "that did not last and is not believed");
}

void PlantClockReport::set_back(CivilTime row, CivilTime clock) {
  say("the plant's clock is {} s behind the row that was waited for; going on from the clock",
      row.seconds - clock.seconds);
}

}  // namespace airside::edge
