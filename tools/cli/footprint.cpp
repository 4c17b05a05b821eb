// airside footprint: the ledger of memory of every room shape in this build.

#include <fmt/format.h>

#include "airside/controller/footprint.hpp"
#include "airside/controller/instances.hpp"
#include "hal/site/site_settings.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

double percent(std::size_t part, std::size_t whole) {
  return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

struct FootprintCommand {
  std::string topology;
  bool json = false;

  /// Whether a site of this shape runs in T: the first topology that holds it.
  template <Topology T>
  static bool is_first_for(const Shape& site) {
    bool is_first = false;
    with_topology(name_of(site).c_str(), [&]<class U>(U) { is_first = std::is_same_v<T, U>; });
    return is_first;
  }

  template <Topology T>
  nlohmann::json ledger() const {
    constexpr auto entries = footprint_ledger<T>();
    const std::size_t total = entries.back().bytes;
    nlohmann::json parts = nlohmann::json::array();
    for (const FootprintEntry& e : entries) {
      parts.push_back({{"name", e.name},
                       {"what", e.what},
                       {"bytes", e.bytes},
                       {"budget_bytes", e.budget_bytes},
                       {"share_of_controller", static_cast<double>(e.bytes) / static_cast<double>(total)}});
    }
    return {{"topology", T::name},
            {"rooms", T::vavs},
            {"inputs", Layout<T>::inputs},
            {"parameters", NetworkWeights<T, float>::count},
            {"blob_bytes", WeightBlob<T>::max_bytes},
            {"parts", parts},
            {"total_bytes", total},
            {"within_budget", within_budget<T>()}};
  }

  template <Topology T>
  void print() const {
    constexpr auto entries = footprint_ledger<T>();
    fmt::print("{}: {} rooms, {} network inputs, {} parameters; a blob has at most {} bytes\n", T::name, T::vavs,
               Layout<T>::inputs, NetworkWeights<T, float>::count, WeightBlob<T>::max_bytes);
    fmt::print("  {:<11} {:<62} {:>10} {:>11} {:>8} {:>7}\n", "part", "what it is", "bytes", "budget", "of that",
               "share");
    for (const FootprintEntry& e : entries) {
      const bool last = &e == &entries.back();
      fmt::print("  {:<11} {:<62} {:>10} {:>11} {:>6.0f} % {:>5.1f} %\n", last ? "total" : e.name, e.what, e.bytes,
                 e.budget_bytes, percent(e.bytes, e.budget_bytes), percent(e.bytes, entries.back().bytes));
    }
    fmt::print("\n");
  }

  void run() const {
    nlohmann::json all = nlohmann::json::array();
    for_each_topology([&]<class T>(T) {
      if (!topology.empty() && !is_first_for<T>(parse_shape(topology.c_str()))) return;
      if (json) {
        all.push_back(ledger<T>());
      } else {
        print<T>();
      }
    });
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"topologies", all}, {"stack_budget_bytes", stack_budget_bytes}}.dump());
    } else {
      fmt::print("stack: a decision or a learning step may use {} bytes; the heap: none after start-up\n",
                 stack_budget_bytes);
    }
  }
};

}  // namespace

void add_footprint(CLI::App& app) {
  auto self = std::make_shared<FootprintCommand>();
  CLI::App* c = app.add_subcommand("footprint", "what a controller costs in memory, part by part, against its budgets");
  c->add_option("--topology", self->topology, "only this one (default: all of this build)")->check(a_topology());
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
