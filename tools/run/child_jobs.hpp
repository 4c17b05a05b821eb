#pragma once
// Independent work in child processes, a few at a time. Co-simulations need it (two engines in one process are not
// repeatable), and it uses all cores without a thread.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace airside::tools {

/// Runs work(0) .. work(count - 1), each in a forked child, at most `jobs` at a time, and returns their texts in order.
/// `done` is called after each. A child does not outlive this process, however that ends; by SIGINT or SIGTERM it is
/// waited for first (clean_up_on_signals()).
/// Errors: std::runtime_error with name(i) and the child's own message, or that it died.
std::vector<std::string> run_children(std::size_t count, int jobs, const std::function<std::string(std::size_t)>& work,
                                      const std::function<std::string(std::size_t)>& name,
                                      const std::function<void()>& done);

}  // namespace airside::tools
