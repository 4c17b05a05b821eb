#pragma once
// Times a call again and again and prints one JSON line a measurement.

#include <time.h>

#include <algorithm>
#include <string>
#include <vector>

#include "airside/topology.hpp"

namespace airside::tools {

/// What is measured: the name, the size of the work, and the shape of site and topology that it is done for.
struct Measured {
  std::string name;
  int batch = 0;
  double flops = 0;           ///< of one call, 0 if not of interest
  Shape shape{};              ///< invalid: of no site
  const char* topology = "";  ///< that the shape runs in
};

class Stopwatch {
 public:
  /// `clock`: CLOCK_MONOTONIC, or the thread's own CPU time where other programs share the cores.
  Stopwatch(clockid_t clock, double budget_s) : clock_(clock), budget_s_(budget_s) {}

  double budget_s() const { return budget_s_; }
  double now_us() const;

  /// Times `work` call by call for about `share` of the budget; `between` is called before each and not timed.
  template <class Work, class Between>
  void measure(const Measured& what, const Work& work, const Between& between, double share = 1) const {
    const auto once = [&] {
      between();
      const double begin = now_us();
      work();
      return now_us() - begin;
    };
    for (int i = 0; i < 5; ++i) once();
    const double guess_us = std::max(0.05, once());
    const int runs = std::clamp(static_cast<int>(share * budget_s_ * 1e6 / guess_us), 15, 20000);
    std::vector<double> us(static_cast<std::size_t>(runs));
    for (double& t : us) t = once();
    print(what, us);
  }
  template <class Work>
  void measure(const Measured& what, const Work& work) const {
    measure(what, work, [] {});
  }

 private:
  static void print(const Measured& what, std::vector<double>& us);

  clockid_t clock_;
  double budget_s_;
};

}  // namespace airside::tools
