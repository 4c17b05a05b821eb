#pragma once
// Which sanitizer this build has: some own the allocator, and none is as small or as fast as what it watches.

namespace airside {

#if defined(__has_feature)
inline constexpr bool thread_sanitized = __has_feature(thread_sanitizer);
inline constexpr bool address_sanitized = __has_feature(address_sanitizer);
#else  // GCC's builds
inline constexpr bool thread_sanitized = false;
inline constexpr bool address_sanitized = false;
#endif
inline constexpr bool sanitized = thread_sanitized || address_sanitized;

}  // namespace airside
