#pragma once
// A loop on several threads.

#include <cstddef>
#include <functional>

namespace airside::tools::gap {

/// work(0) .. work(count - 1), on `jobs` threads, in about that order.
/// Errors: the first that was thrown, after all threads have ended; what had not begun by then is left out.
void in_parallel(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

}  // namespace airside::tools::gap
