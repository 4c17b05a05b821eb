#pragma once
// Registers in EEPROM wear out: 80 writes a day are 100,000 in three and a half years. A budget holds the setpoint
// where a small move is not worth a write.

#include <algorithm>
#include <cmath>

namespace airside {

/// Tokens that are earned by the cycle and spent by the write.
///   tokens += writes_per_day / cycles per day, at most a quarter of a day's;  a move counts if |move| >= 0.5 K - 0.09
///   K tokens, and never below 0.05 K; without a token it must be 2 K
/// so that the long average keeps the budget, and a large move is never late. Plain bytes, part of the durable state.
/// Source: docs/box-and-safety.md, "Write budget".
class WriteBudget {
 public:
  /// Once a cycle, on every control mode.
  void earn(double writes_per_day, int cycles_per_day) {
    tokens_ = std::min(tokens_ + writes_per_day / cycles_per_day, writes_per_day / 4);
  }
  /// Whether a move of `move_k` is worth a write now.
  bool allows(double move_k, double writes_per_day) const {
    const double least_k = tokens_ < 1 ? 2.0 : std::max(0.05, 0.5 - 0.09 * tokens_);
    return std::abs(move_k) >= least_k && tokens_ >= 1 - writes_per_day;  // nor while the debt is a day's
  }
  /// A setpoint was written, allowed or forced by the mode arbiter; what is forced makes a debt of a day at most.
  void spend(double writes_per_day) { tokens_ = std::max(tokens_ - 1, -writes_per_day); }
  double tokens() const { return tokens_; }

 private:
  double tokens_ = 0;
};

}  // namespace airside
