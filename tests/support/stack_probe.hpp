#pragma once
// How deep a call really goes: it runs on a painted stack of its own, and the paint that is left is counted.

#include <cstddef>
#include <type_traits>

namespace airside::footprint {

/// Bytes of stack that `run(context)` used at its deepest beyond those of an empty call.
/// Errors: throws std::runtime_error if no thread could be started or the call used more than 7 MB. Sanitizers and -O0
/// make frames several times wider.
std::size_t stack_used(void (*run)(void*), void* context);

/// The same for a callable without arguments.
template <class Callable>
std::size_t stack_used(Callable&& callable) {
  using Plain = std::remove_reference_t<Callable>;
  return stack_used([](void* context) { (*static_cast<Plain*>(context))(); }, &callable);
}

}  // namespace airside::footprint
