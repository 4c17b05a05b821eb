#include "firmware/page/response.hpp"

#include <fmt/format.h>

namespace airside::page {

std::string without_markup(std::string_view json) {
  std::string safe;
  for (const char c : json) {
    switch (c) {
      case '<': safe += "\\u003c"; break;
      case '>': safe += "\\u003e"; break;
      case '&': safe += "\\u0026"; break;
      default: safe += c;
    }
  }
  return safe;
}

MHD_Response* response_of(const std::string& text) {
  // The library takes a void* that it does not write to when it copies.
  return MHD_create_response_from_buffer(text.size(), const_cast<char*>(text.data()), MHD_RESPMEM_MUST_COPY);
}

MHD_Response* json_of(int status, std::string_view reason) {
  return response_of(without_markup(fmt::format("{{\"status\":{},\"reason\":\"{}\"}}\n", status, reason)));
}

void add_common_lines(MHD_Response* response) {
  const char* type = MHD_get_response_header(response, "Content-Type");
  if (type == nullptr) MHD_add_response_header(response, "Content-Type", "application/json; charset=utf-8");
  static constexpr const char* always[][2] = {
      {"Connection", "close"},
      {"Cache-Control", "no-store"},
      {"X-Content-Type-Options", "nosniff"},
      {"Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; sandbox"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "no-referrer"},
  };
  for (const auto& [name, value] : always) MHD_add_response_header(response, name, value);
}

}  // namespace airside::page
