#include "tools/chaos/chaos_frame.hpp"

namespace airside::tools {

namespace {

using Bytes = std::vector<std::uint8_t>;
using hal::get16;
using hal::put16;

}  // namespace

ChaosRequest parsed(const Bytes& adu) {
  ChaosRequest r;
  r.function = adu[7];
  if (adu.size() >= 10) r.addr = static_cast<int>(get16(&adu[8]));
  const bool counted = r.function <= 4 || r.function == 15 || r.function == 16;
  if (counted && adu.size() >= 12) r.count = static_cast<int>(get16(&adu[10]));
  return r;
}

Bytes confirmation_of(const Bytes& asked) {
  Bytes answer(asked.begin(), asked.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(asked.size(), 12)));
  put16(&answer[4], static_cast<unsigned>(answer.size() - 6));
  return answer;
}

Bytes exception_to(const Bytes& asked, int code) {
  Bytes answer(asked.begin(), asked.begin() + 8);
  put16(&answer[4], 3);
  answer[7] = static_cast<std::uint8_t>(answer[7] | 0x80U);
  answer.push_back(static_cast<std::uint8_t>(code));
  return answer;
}

std::size_t place_of(const ChaosRequest& r, const Bytes& answer, int addr) {
  if ((r.function != 3 && r.function != 4) || addr < r.addr || addr >= r.addr + r.count) return 0;
  const std::size_t at = 9 + 2 * static_cast<std::size_t>(addr - r.addr);
  return at + 1 < answer.size() ? at : 0;
}

bool touches(const ChaosFault& fault, const ChaosRequest& r) {
  switch (fault.kind) {
    case ChaosKind::clamp:
    case ChaosKind::alter:
    case ChaosKind::swallow: return r.writes();
    case ChaosKind::swap:
    case ChaosKind::set: {
      const double wide = fault.kind == ChaosKind::swap ? 2 * fault.param[1] : 1;
      return (r.function == 3 || r.function == 4) && fault.param[0] < r.addr + r.count &&
             fault.param[0] + wide > r.addr;
    }
    default: return true;
  }
}

}  // namespace airside::tools
